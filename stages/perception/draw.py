"""Command `draw`: one photograph without depth -> a drawing and an input folder, by no hand (paper 2.1)."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.perception import DrawOptions
from roomkin.stages.contracts import InputError, read_json, read_options, write_json
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.hand import PROJECT, command_for, find_hand_file, is_by_hand
from roomkin.stages.contracts.system import lock_folder
from roomkin.stages.perception.classification.by_size import name_others, name_standing
from roomkin.stages.perception.classification.names import find_reason, find_surest, place_sure
from roomkin.stages.perception.classification.propose import list_silent
from roomkin.stages.perception.drawing.project import Project
from roomkin.stages.perception.drawing.room import add_found, draw_room
from roomkin.stages.perception.drawing.solve import UNSURE, Solved
from roomkin.stages.perception.drawing.write import finish_drawing, write_folder
from roomkin.stages.perception.layout.ends import measure_all, number_masks
from roomkin.stages.perception.layout.room import FittedRoom, arrange, build_room, scale_room, see_camera, tell_camera
from roomkin.stages.perception.layout.things import see_outlines
from roomkin.stages.perception.read.photo import read_known
from roomkin.stages.perception.segmentation.proposal import find_border
from roomkin.stages.perception.write import check_folder


class Drawn(NamedTuple):
    """A drawing, the same solved, the room that it is of, masks (H, W) and labels of its things, and things whose
    known height helped nothing, as none is found."""

    project: Project
    solved: Solved
    room: FittedRoom
    masks: NDArray[np.uint16]
    labels: dict[int, str]
    missing: list[str]


def run(*, image: Path, out: Path, drawing: Path | None = None, options: str = "{}", device: str = "cpu") -> None:
    """Find what a picture shows and where, by lines, outlines and usual sizes, and write it as a person would draw it.

    A drawing of the picture that a person has changed is taken as it is (`roomkin.stages.contracts.hand`).

    Args:
        image: the picture.
        out: the input folder to write; what was found as project.json, which `annotator annotate` opens.
        drawing: project.json that is taken in the place of all that.
        options: JSON of the config section `perception`.
        device: of networks: cpu or cuda.

    Raises:
        InputError: nothing that is known is seen; the drawing is of another picture.
    """
    settings = read_options(DrawOptions, options)
    photo, focal, _ = read_known(image, settings)
    check_folder(out, photo.digest)
    path, note = find_hand_file(out, PROJECT, lambda: photo.digest), ""
    if path.name != PROJECT:
        print(f"{path.with_name(PROJECT)}: is of another picture: kept, not used")
    given = drawing or (path if is_by_hand(path) else None)
    if given is None:
        drawn = draw_picture(image.name, photo.rgb, focal, settings, device)
        project = drawn.project.model_copy(update={"digest": photo.digest})
        solved, note = drawn.solved, tell_camera(drawn.room)
        with lock_folder(out):
            if is_by_hand(path):  # by now: a person drew while the picture was looked at
                given = path
            else:
                write_json(path if path.parent == out else out / PROJECT, project)
    if given is None:
        left_out = [f"{one.guess}: left out: {one.left_out}" for one in project.left_out]
        missing = [f"perception.heights: no {label} is found" for label in drawn.missing]
        counted = f"{count(len(project.objects), 'thing')}, {count(len(project.walls), 'wall')}"
        print("\n".join([counted, note, *left_out, *missing, *list_silent()]))
    else:
        (height, width), mend = photo.rgb.shape[:2], "give the picture that was drawn into"
        project = read_json(Project, given).check_picture(photo.digest, width, height, given, mend)
        project, solved = finish_drawing(project, None)
        project, note = project.model_copy(update={"digest": photo.digest}), ""
        if given == path:
            print(f"{path}: drawn by a person: kept; delete it to begin anew")
    written = write_folder(out, photo.rgb, project, solved, note=note)
    print("".join(f"{note}\n" for note in written.notes if not note.endswith(UNSURE)), end="")
    print(f"{out}: put it right in the browser: {command_for(out)}")


def draw_picture(
    name: str, rgb: NDArray[np.uint8], focal: float | None, options: DrawOptions, device: str = "cpu"
) -> Drawn:
    """The drawing of what a picture (H, W, 3) shows.

    1. Outlines, and their names by looks.
    2. What COCO's network knows gives the camera; by it, what else stands there is named by its size.
    3. All that stands gives the camera, and with lines on the floor the walls.
    4. By these, what rests on something or hangs is named by its size, and placed.

    Args:
        name: file name of the picture.
        focal: pixels, if it is known.

    Raises:
        InputError: nothing is known there.
    """
    seen, inside = see_outlines(rgb, options, device), ~find_border(rgb)
    masks = number_masks({value: one.mask for value, one in enumerate(seen, 1)}, inside.shape)
    feet = measure_all(masks, range(1, len(seen) + 1), inside)
    named = {value: one.names for value, one in enumerate(seen, 1) if one.is_sure}
    camera, labels = see_camera(rgb, focal), place_sure(named, 0.0)
    known = arrange(camera, masks, labels, inside)
    more, carriers = name_standing(seen, masks, feet, known, labels, inside)
    labels = place_sure(named | more, options.sure, carriers)
    standing = arrange(camera, masks, labels, inside)
    room = build_room(rgb, standing, masks)
    others = name_others(seen, masks, feet, room, standing.kinds)
    named |= more | others
    if not named:
        mend = "draw it: roomkin annotator annotate"
        raise InputError(name, "shows no thing that is known.", mend, code="E-SCENE-EMPTY")
    surest = find_surest(named)
    alone = {} if labels else {surest: named[surest].proposals[0].name}
    if sure := place_sure(others, options.sure) or alone:
        labels |= sure
        room = build_room(rgb, arrange(camera, masks, labels, inside, standing), masks, standing)
    room = scale_room(room, labels, options.heights)
    project, solved, left_out = draw_room(name, room, masks, labels)
    left_out |= {value: find_reason(names, options.sure) for value, names in named.items() if value not in labels}
    missing = [label for label in options.heights if label not in {"camera", *labels.values()}]
    return Drawn(add_found(project, masks, named, left_out), solved, room, masks, labels, missing)
