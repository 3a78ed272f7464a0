"""Command `see`: a picture with depth -> its things, outlined, named and captioned, as an input folder (paper A.2)."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.cli import progress
from roomkin.stages.config.perception import OutlineSection, SeeOptions, SeeSection
from roomkin.stages.config.weights import CLIP, list_lacking
from roomkin.stages.contracts import Camera, InputError, read_json, read_options, write_atomically, write_json
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.hand import command_for, digest_of_picture
from roomkin.stages.contracts.images import check_turned, read_depth, read_rgb
from roomkin.stages.contracts.scenes import Held
from roomkin.stages.contracts.things import THINGS, Ground, Thing, Things
from roomkin.stages.contracts.types import FLOOR, WALL
from roomkin.stages.geometry.frames import back_project
from roomkin.stages.geometry.levels import BELOW
from roomkin.stages.geometry.masks import pixel_bounds
from roomkin.stages.perception.camera.surfaces import Surfaces, find_surfaces
from roomkin.stages.perception.classification.names import UNSURE, LikelyName, Names, find_surest
from roomkin.stages.perception.classification.naming import Named, name_things
from roomkin.stages.perception.classification.propose import list_silent
from roomkin.stages.perception.read.frame import TILT, Frame, Labelled, doubt_depth
from roomkin.stages.perception.segmentation.choosing import choose
from roomkin.stages.perception.segmentation.proposal import Mask, RoomView, list_proposals
from roomkin.stages.perception.write import NAMES, draw_numbers, tell_names, write_frame
from roomkin.stages.plugins import load

Box = Sequence[float]
WANT_WEIGHTS = {"ssd", "mobile_sam"}  # proposers
WITHOUT = "pieces"  # what proposes where those weights lack


class Captioner(Protocol):
    """A language model that says what is in a picture (H, W, 3); `captioners/<name>.py` of a package defines one."""

    def list_labels(self, rgb: NDArray[np.uint8]) -> list[str]:
        """What is in the picture."""

    def caption(
        self, rgb: NDArray[np.uint8], box: Box, label: str, labels: Sequence[str], number: int
    ) -> dict[str, Any] | None:
        """Of the thing in a box label, articulated, doors, drawers; empty: not known; None: it is no whole thing."""

    def hold(
        self, rgb: NDArray[np.uint8], box: Box, walls: Sequence[Mask], label: str, number: int
    ) -> tuple[int, list[int]] | None:
        """How the thing in a box is held: type 1, 2, 3, and the walls that it touches, by places; None: unknown."""

    def summary(self) -> str:
        """What was asked, in a line."""


def caption_things(captioner: Captioner, view: RoomView, things: Sequence[Named], options: SeeSection) -> list[Named]:
    """The things as they are captioned: what has a caption has a sure name; what is no whole thing is left out."""
    found = list(things)
    asked = [k for k, one in enumerate(things) if not one.left_out or one.left_out in UNSURE]
    for k in progress(asked, "objects"):
        one, label = things[k], word_of(things[k])
        said = captioner.caption(view.rgb, pixel_bounds(one.outlined.mask), label, options.labels, k + 1)
        if said is None:
            found[k] = replace(one, left_out="no whole thing, says the language model")
        elif said:
            names = Names([LikelyName(said["label"], 1.0)], 0.0)
            found[k] = replace(one, names=names, left_out="", stated=said)
    walls = view.surfaces.wall_masks
    if options.mounting == "vlm" and not walls:
        print("no wall is found: mounting by geometry")
    held = [k for k in asked if found[k].stated] if options.mounting == "vlm" and walls else []
    for k in progress(held, "mountings"):
        box, label = pixel_bounds(found[k].outlined.mask), word_of(found[k])
        how = captioner.hold(view.rgb, box, walls, label, k + 1)
        found[k] = replace(found[k], stated={**found[k].stated, "mounting": how})
    print(captioner.summary())
    return found


def word_of(one: Named) -> str:
    """What a thing is called: by a caption, by what detected it, by its looks."""
    words = one.outlined.words
    return str(one.stated.get("label") or max(words, key=words.__getitem__, default=one.names.proposals[0].name))


def state(said: Mapping[str, Any], walls: Sequence[int], shown: Collection[int]) -> dict[str, Any]:
    """A caption as an annotation has it; a mounting counts if all of its walls are seen.

    walls, shown: mask values of all walls, and of what has pixels left.
    """
    stated = {key: said[key] for key in ("articulated", "doors", "drawers") if key in said}
    if said.get("mounting"):
        kind, places = said["mounting"]
        touched = [walls[place] for place in places]
        if set(touched) <= set(shown):
            stated["mounting"] = Held.model_validate({"type": kind, "walls": touched})
        else:
            print(f"{said['label']}: mounting by geometry, its wall is all covered")
    return stated


@dataclass(frozen=True)
class Seen:
    """Ground, walls and things; those without a reason to be left out are placed."""

    surfaces: Surfaces
    things: list[Named]


def run(*, picture: Path, out: Path, options: str = "{}", device: str = "cpu") -> None:
    """Find and name the things of a picture.

    Args:
        picture: folder with rgb.png, depth.npz and camera.json, as `from-rgbd` and `measure` write it.
        out: the input folder to write (docs/scenes.md), with things.json: what was found, and what is left out.
        options: JSON of the config section `perception`, with that of the language model.
        device: of networks: cpu or cuda.
    """
    settings = read_options(SeeOptions, options)
    camera = read_json(Camera, picture / "camera.json")
    depth, _ = read_depth(picture / "depth.npz")
    pose = None if camera.floor_from_camera is None else np.array(camera.floor_from_camera, dtype=float)
    intrinsics = np.array(camera.intrinsics, dtype=float)
    rgb = read_rgb(picture / "rgb.png")
    digest = digest_of_picture(picture)
    doubt = doubt_depth(depth, rgb)
    if doubt:
        print(f"{picture}: {doubt}")
    note = camera.note if doubt in camera.note else "; ".join(filter(None, [camera.note, doubt]))
    frame = Frame(rgb, depth, intrinsics, doubt=note, pose=pose, picture=camera.picture, digest=digest)
    write_seen(out, frame, see(frame, settings, settings.vlm, device))


def write_seen(out: Path, frame: Frame, seen: Seen) -> None:
    """Write what was seen in a frame as an input folder, with things.json and, for people, numbers.png."""
    masks, things = label(seen)
    written = write_frame(out, replace(frame, masks=masks))
    assert written is not None
    write_json(out / THINGS, things)
    with write_atomically(out / "numbers.png") as path:
        shown = draw_numbers(frame.rgb, [masks.values == item.mask for item in written.objects])
        cv2.imwrite(str(path), shown[..., ::-1])
    print(describe(things))
    print(f"{out}: put names right in the browser: {command_for(out)}")


def see(frame: Frame, options: SeeSection, model: Mapping[str, Any] | None = None, device: str = "cpu") -> Seen:
    """Ground, walls and things of a frame whose depth has the size of its picture.

    Args:
        model: the config section `vlm`, for `captions: vlm`.

    Raises:
        InputError: nothing level is seen, or no thing.
    """
    captioner = None if options.captions == "labels" else load("captioners", options.captions)(model or {})
    if captioner is not None:
        options = options.model_copy(update={"labels": captioner.list_labels(frame.rgb)})
    view = look(frame, device)
    things = name_things(view, choose(view, list_proposals(view, options, list_proposers(options))), options.sure)
    if captioner is not None:
        things = caption_things(captioner, view, things, options)
    else:
        print("".join(f"{line}\n" for line in list_silent()), end="")
    if not things:
        raise InputError("the picture", "shows no thing.", "give --masks, or draw boxes", code="E-MASKS-EMPTY")
    return Seen(view.surfaces, things)


def look(frame: Frame, device: str = "cpu") -> RoomView:
    """A frame with its ground and walls.

    Raises:
        InputError: nothing level is seen.
    """
    depth = frame.depth.astype(float)
    surfaces = find_surfaces(depth, frame.intrinsics, TILT, frame.pose)
    if surfaces is None:
        check_turned("depth", back_project(depth, frame.intrinsics), depth > 0, TILT)
        mend = "check depth (metres) and intrinsics"
        raise InputError("depth", "shows no level surface.", mend, code="E-FLOOR-MISSING")
    return RoomView(frame.rgb, depth, frame.intrinsics, surfaces, device)


def list_proposers(options: OutlineSection) -> list[str]:
    """The proposers that are asked; where weights lack, `WITHOUT` in the place of those that want them, with a line."""
    lacking = [name for name in list_lacking() if name != CLIP.name]
    if not lacking or not WANT_WEIGHTS & set(options.proposers):
        return options.proposers
    print(f"no {', '.join(lacking)} (make weights): outlines by depth alone, right less often")
    return [*(name for name in options.proposers if name not in WANT_WEIGHTS), WITHOUT]


def label(seen: Seen) -> tuple[Labelled, Things]:
    """Masks with the labels of what is placed, floor and walls; and things.json.

    Where no thing is sure, the surest is placed all the same: a scene has one.
    """
    things = seen.things
    if all(one.left_out for one in things):
        unsure = {k: one.names for k, one in enumerate(things) if one.left_out in UNSURE}
        surest = find_surest(unsure or {k: one.names for k, one in enumerate(things)})
        things = [replace(one, left_out="") if k == surest else one for k, one in enumerate(things)]
    surfaces = seen.surfaces
    values = np.zeros(surfaces.ground.shape, dtype=np.uint16)
    floor, walls = len(things) + 1, list(range(len(things) + 2, len(things) + 2 + len(surfaces.walls)))
    values[surfaces.ground] = floor
    for value, mask in zip(walls, surfaces.wall_masks, strict=True):
        values[mask] = value
    for value, one in enumerate(things, 1):
        values[one.outlined.mask] = value
    placed = {value: one for value, one in enumerate(things, 1) if not one.left_out}
    labels = {value: one.names.proposals[0].name for value, one in placed.items()}
    labels |= {floor: FLOOR} | dict.fromkeys(walls, WALL)
    proposals = {value: one.names.proposals[:NAMES] for value, one in placed.items() if not one.stated}
    shown = set(np.unique(values).tolist())
    stated = {value: state(one.stated, walls, shown) for value, one in placed.items() if one.stated}
    return Labelled(values, labels, proposals, stated=stated), tell(seen, things)


def tell(seen: Seen, things: list[Named]) -> Things:
    """things.json."""
    surfaces, told = seen.surfaces, []
    for value, one in enumerate(things, 1):
        score, source = round(min(one.outlined.score, 1.0), 4), one.outlined.source
        thing = Thing(mask=value, score=score, source=source, left_out=one.left_out, **dict(tell_names(one.names)))
        told.append(thing)
    lower = round(100 * surfaces.below, 1)
    what = f"a level surface ({lower:g} % of the points lie lower)" if lower else "the lowest level surface"
    what = "a table top near the camera" if surfaces.below > BELOW else what
    height, share = round(float(surfaces.frame[2, 3]), 3), round(float(surfaces.ground.mean()), 4)
    ground = Ground(camera_height=height, taken_from=what, share=share)
    return Things(ground=ground, walls=len(surfaces.walls), things=told)


def describe(things: Things) -> str:
    """The findings, in a line for people."""
    assert things.ground is not None
    left, all_ = len(things.left_out), len(things.things)
    walls = count(things.walls, "wall")
    height = f"the camera is {things.ground.camera_height:.2f} m above {things.ground.taken_from}"
    return f"{count(all_ - left, 'thing')}, {left} more left out as unsure, {walls}; {height}"
