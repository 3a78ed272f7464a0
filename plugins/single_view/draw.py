"""Command `draw`: one photograph without depth -> a drawing and an input folder, by no hand (paper 2.1)."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plugins.annotator.project import PROJECT, Project
from plugins.annotator.solve import UNSURE
from plugins.annotator.write import write_folder
from plugins.inputs.photo.picture import read_photo
from plugins.inputs.rgbd.cameras import intrinsics_of_view
from plugins.single_view.config import DrawOptions
from plugins.single_view.drawing import draw_room
from plugins.single_view.naming import name_others, name_standing
from plugins.single_view.room import Room, build_room, scale_room, see_camera
from plugins.single_view.things import number_labelled, see_outlines
from stages.contracts import InputError, read_json, read_options, write_json
from stages.contracts.words import count


class Drawn(NamedTuple):
    """A drawing, the room that it is of, masks (H, W) and labels of its things, and lines about what is left out."""

    project: Project
    room: Room
    masks: NDArray[np.uint16]
    labels: dict[int, str]
    left_out: list[str]


def run(*, image: Path, out: Path, drawing: Path | None = None, options: str = "{}") -> None:
    """Find what a picture shows and where, and write it as a person would draw it.

    A drawing in the folder that a person has changed is kept, and written anew.

    Args:
        image: the picture.
        out: the input folder to write, with project.json, which `annotator annotate` opens.
        drawing: project.json that is taken in the place of all that.
        options: JSON of the config section `single_view`, with `field_of_view` and `lens` of `photo`.

    Raises:
        InputError: nothing that is known is seen; the drawing is of a picture of another size.
    """
    settings = read_options(DrawOptions, options)
    photo = read_photo(image, Path(settings.lens) if settings.lens else None)
    focal = photo.focal
    if settings.field_of_view is not None:
        height, width = photo.rgb.shape[:2]
        focal = float(intrinsics_of_view(settings.field_of_view, width, height)[0, 0])
    path, note = out / PROJECT, ""
    kept = read_json(Project, path) if path.is_file() else None
    if drawing is not None:
        project = read_drawing(drawing, photo.rgb)
        write_json(path, project)
    elif kept is not None and not kept.untouched:
        project = read_drawing(path, photo.rgb)
        print(f"{path}: drawn by a person: kept; delete it to begin anew")
    else:
        drawn = draw_picture(image.name, photo.rgb, focal, settings.heights)
        project, note = drawn.project, describe_camera(drawn.room)
        write_json(path, project)
        print("\n".join([count_things(project), note, *drawn.left_out]))
    written = write_folder(out, photo.rgb, project, note=note)
    print("".join(f"{note}\n" for note in written.notes if not note.endswith(UNSURE)), end="")
    print(f"{out}: put it right in the browser: python -m plugins.annotator annotate {image} --out {out}")


def read_drawing(path: Path, rgb: NDArray[np.uint8]) -> Project:
    """The drawing in a file, checked to be of a picture as large as this one (H, W, 3)."""
    height, width = rgb.shape[:2]
    return read_json(Project, path).check_size(width, height, path, "give the picture that was drawn into")


def draw_picture(
    name: str, rgb: NDArray[np.uint8], focal: float | None = None, heights: Mapping[str, float] | None = None
) -> Drawn:
    """The drawing of what a picture (H, W, 3) shows.

    First the room of those things that COCO's network knows; by the camera that they give, what else stands there; by
    these, what rests on them or hangs; then the room of all.

    Args:
        name: file name of the picture.
        focal: pixels, if it is known.
        heights: metres, of things by their labels, and of the `camera`.

    Raises:
        InputError: nothing is known there.
    """
    seen, heights = see_outlines(rgb), heights or {}
    labels = {value: one.names.proposals[0].name for value, one in enumerate(seen, 1) if one.is_sure}
    camera = see_camera(rgb, focal)
    for name_more in (name_standing, name_others):
        labels |= name_more(rgb, seen, build_room(rgb, camera, number_labelled(rgb, seen, labels), labels), labels)
    if not labels:
        mend = "draw it: python -m plugins.annotator annotate"
        raise InputError(name, "shows no thing that is known.", mend, code="E-SCENE-EMPTY")
    masks = number_labelled(rgb, seen, labels)
    room = scale_room(build_room(rgb, camera, masks, labels), labels, heights)
    project, left_out = draw_room(name, room, masks, labels)
    lines = [f"{labels[value]}: left out: {why}" for value, why in left_out.items()]
    lines += [
        f"single_view.heights: no {label} is found" for label in heights if label not in {"camera", *labels.values()}
    ]
    return Drawn(project, room, masks, labels, lines)


def count_things(project: Project) -> str:
    """What was found, in a line for people."""
    return f"{count(len(project.objects), 'thing')}, {count(len(project.walls), 'wall')}"


def describe_camera(room: Room) -> str:
    """The camera, each number with its spread (one standard deviation), for people."""
    view, spread = room.view, room.spread
    down = float(np.degrees(np.arcsin(-view.rotation[2, 2])))
    height = f" (± {spread.height * view.above:.2f})" if spread.height else ""
    told = (
        f"the camera is {view.above:.2f} m{height} above the floor and looks {down:.1f} degrees "
        f"(± {np.degrees(spread.tilt):.1f}) down, its focal length is {view.focal:.0f} pixels "
        f"(± {spread.focal * view.focal:.0f})"
    )
    return "; ".join(filter(None, [told, room.doubt]))
