"""Command `see`: a picture with depth -> its things, outlined and named, as an input folder (paper A.2, first half)."""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from plugins.eyes.choosing import choose
from plugins.eyes.config import EyesSection
from plugins.eyes.naming import Named, name_things
from plugins.eyes.proposal import Proposal, RoomView
from plugins.eyes.surfaces import Surfaces, find_surfaces
from plugins.eyes.weights import ALL, is_there
from plugins.inputs.numbered import draw_numbers
from plugins.inputs.rgbd.belonging import doubt_depth
from plugins.inputs.rgbd.frame import TILT, Frame, Labelled
from plugins.inputs.rgbd.surfaces import surface_of
from plugins.inputs.rgbd.write import write_frame
from plugins.names.observed import WITHOUT as WITHOUT_CLASSES
from plugins.names.observed import classifier
from stages.contracts import Camera, InputError, read_json, read_options, write_atomically, write_json
from stages.contracts.depth import read_depth
from stages.contracts.images import read_rgb
from stages.contracts.things import THINGS, Ground, Name, Thing, Things
from stages.contracts.types import FLOOR, WALL
from stages.contracts.words import count
from stages.geometry.levels import BELOW
from stages.plugins import load

WANT_WEIGHTS = {"ssd", "mobile_sam"}  # proposers
WITHOUT = "pieces"  # what proposes where those weights lack
NAMES = 5  # of a thing that are told; chosen


@dataclass(frozen=True)
class Seen:
    """Ground, walls and things; those without a reason to be left out are placed."""

    surfaces: Surfaces
    things: list[Named]


def run(*, picture: Path, out: Path, options: str = "{}") -> None:
    """Find and name the things of a picture.

    Args:
        picture: folder with rgb.png, depth.npz and camera.json, as `inputs from-rgbd` writes it.
        out: the input folder to write (docs/scenes.md), with things.json: what was found, and what is left out.
        options: JSON of the config section `eyes`.
    """
    settings = read_options(EyesSection, options)
    camera = read_json(Camera, picture / "camera.json")
    depth, _ = read_depth(picture / "depth.npz")
    frame = Frame(read_rgb(picture / "rgb.png"), depth, np.array(camera.intrinsics, dtype=float))
    seen = see(frame, settings)
    masks, things = label(seen)
    doubt = doubt_depth(depth, masks.values, [value for value, name in masks.labels.items() if not surface_of(name)])
    if doubt:
        print(f"{picture / 'depth.npz'}: {doubt}")
    doubts = "; ".join(filter(None, [camera.note, doubt]))
    written = write_frame(out, replace(frame, masks=masks, doubt=doubts))
    assert written is not None
    write_json(out / THINGS, things)
    with write_atomically(out / "numbers.png") as path:
        shown = draw_numbers(frame.rgb, [masks.values == item.mask for item in written.objects])
        cv2.imwrite(str(path), shown[..., ::-1])
    print(describe(things))
    print(f"{out}: put names right in the browser: python -m plugins.annotator annotate {out}")


def see(frame: Frame, options: EyesSection) -> Seen:
    """Ground, walls and things of a frame whose depth has the size of its picture.

    Raises:
        InputError: nothing level is seen, or no thing.
    """
    view = look(frame)
    things = name_things(view, choose(view, propose(view, options)), options.sure)
    if classifier() is None:
        print(WITHOUT_CLASSES)
    if not things:
        raise InputError("the picture", "shows no thing.", "give --masks, or draw boxes", code="E-MASKS-EMPTY")
    return Seen(view.surfaces, things)


def propose(view: RoomView, options: EyesSection) -> list[Proposal]:
    """The proposals of all proposers."""
    return [one for name in list_proposers(options) for one in load("proposers", name)(view)]


def look(frame: Frame) -> RoomView:
    """A frame with its ground and walls.

    Raises:
        InputError: nothing level is seen.
    """
    depth = frame.depth.astype(float)
    surfaces = find_surfaces(depth, frame.intrinsics, TILT)
    if surfaces is None:
        raise InputError(
            "depth", "shows no level surface.", "check depth (metres) and intrinsics", code="E-FLOOR-MISSING"
        )
    return RoomView(frame.rgb, depth, frame.intrinsics, surfaces)


def list_proposers(options: EyesSection) -> list[str]:
    """The proposers that are asked; where weights lack, `WITHOUT` in the place of those that want them, with a line."""
    lacking = [weights.name for weights in ALL if not is_there(weights)]
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
        surest = max(range(len(things)), key=lambda k: things[k].names.proposals[0].probability)
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
    proposals = {value: one.names.proposals[:NAMES] for value, one in placed.items()}
    return Labelled(values, labels, proposals), tell(seen, things)


def tell(seen: Seen, things: list[Named]) -> Things:
    """things.json."""
    surfaces, told = seen.surfaces, []
    for value, one in enumerate(things, 1):
        names = [Name(name=p.name, probability=round(p.probability, 4)) for p in one.names.proposals[:NAMES]]
        other, score = round(one.names.other, 4), round(min(one.outlined.score, 1.0), 4)
        source = one.outlined.source
        told.append(Thing(mask=value, names=names, other=other, score=score, source=source, left_out=one.left_out))
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
