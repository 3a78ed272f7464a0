"""Command `baselines`: what the dumbest methods get, as submissions."""

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.scorecard.measures import knows_hinges
from roomkin.plugins.scorecard.truth import PictureTruth, TrueThing, list_rooms, read_truth
from roomkin.stages.contracts import write_json
from roomkin.stages.contracts.categories import sizes_of
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import invert_transform, make_transform, transform_points, yaw_matrix

MOVED = 0.05  # metres
USUAL = (0.4, 0.4, 0.4)  # metres, of what nobody knows
CODE = "roomkin scorecard baselines"
ABOUT: dict[str, dict[str, Any]] = {
    "truth_moved": {
        "method": "baseline: the truth, every thing moved by 5 cm",
        "given": ["depth", "exact masks", "names", "panels", "camera pose"],
        "seen": "everything: it is made of the truth",
    },
    "usual_boxes": {
        "method": "baseline: boxes of usual size at the outlines",
        "given": ["depth", "exact masks", "names", "camera pose"],
        "seen": "nothing",
    },
    "other_room": {
        "method": "baseline: another room of its kind, no image",
        "given": ["camera pose"],
        "seen": "the truth of another room of the same set and kind, shown in its place",
    },
}


def run(*, rooms: str, data: Path = Path("rooms"), out: Path = Path("baselines")) -> None:
    """Write truth_moved.json, usual_boxes.json and other_room.json, submissions for a set of rooms.

    Args:
        rooms: the set, e.g. work.
        data: folder of the rooms.
        out: folder of the submissions.
    """
    folders = list_rooms(data, rooms)
    truths = [read_truth(folder / "truth.json") for folder in folders]
    found: dict[str, dict[str, Any]] = {name: {} for name in ABOUT}
    for number, (folder, truth) in enumerate(zip(folders, truths, strict=True)):
        moved = np.random.default_rng(number)
        found["truth_moved"][truth.name] = describe_room(truth, move_things(truth, moved))
        found["usual_boxes"][truth.name] = describe_room(truth, guess_boxes(folder, truth))
        found["other_room"][truth.name] = describe_room(truth, copy_other(truth, truths))
    for name, about in ABOUT.items():
        head = {"version": 1, **about, "code": CODE, "by": "this project", "note": ""}
        write_json(out / f"{name}.json", head | {"rooms": found[name]})
    print(f"{out}: {', '.join(f'{name}.json' for name in ABOUT)}")


def describe_room(truth: PictureTruth, things: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """A room of a submission, in the truth's own frame."""
    return {"frame": "floor", "floor_from_camera": truth.pose.round(6).tolist(), "things": list(things)}


def describe_thing(thing: TrueThing, center: NDArray[np.float64], size: Sequence[float], yaw: float) -> dict[str, Any]:
    """A thing of a submission."""
    box = {"center": np.round(center, 4).tolist(), "size": np.round(size, 4).tolist(), "yaw": round(float(yaw), 4)}
    return {"name": thing.label, **box}


def move_things(truth: PictureTruth, rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """The true things, each moved level by `MOVED` into a direction of its own."""
    for thing in truth.list_asked(drawn=False):
        step = yaw_matrix(rng.uniform(-np.pi, np.pi)) @ [MOVED - 1e-4, 0, 0]
        said = describe_thing(thing, np.array(thing.position) + step, thing.size, thing.yaw)
        opens = list(thing.opens) if knows_hinges(thing.opens) else []
        pose = make_transform(yaw_matrix(thing.yaw), np.array(thing.position) + step)
        handles = [transform_points(pose, handle.position).round(4).tolist() for handle in thing.handles]
        yield said | {"number": thing.number, "opens": opens, "handles": handles}


def guess_boxes(folder: Path, truth: PictureTruth) -> Iterator[dict[str, Any]]:
    """A box of the median model of its name for every outline: its near side at the outline's median depth, its front
    towards the camera."""
    depth, masks = read_depth(folder / f"depth_{truth.device}.png"), read_depth(folder / "masks_exact.png")
    camera = json.loads((folder / "camera.json").read_text(encoding="utf-8"))
    eye = truth.pose[:3, 3]
    for thing in truth.list_asked(drawn=False):
        rows, columns = np.nonzero((masks == thing.number) & (depth > 0))
        sizes = sizes_of(thing.label)
        size = np.median(sizes, axis=0) if len(sizes) else np.array(USUAL)
        if not len(rows):
            continue
        far = depth[rows, columns] / 1000
        rays = np.column_stack([(columns - camera["cx"]) / camera["fx"], (rows - camera["cy"]) / camera["fy"]])
        points = transform_points(truth.pose, np.column_stack([rays, np.ones(len(rays))]) * far[:, None])
        near = np.median(points, axis=0)
        yaw = float(np.arctan2(*(eye - near)[1::-1]))
        center = near - yaw_matrix(yaw) @ [size[0] / 2, 0, 0]
        yield describe_thing(thing, center, size.tolist(), yaw) | {"number": thing.number}


def copy_other(truth: PictureTruth, truths: Sequence[PictureTruth]) -> Iterator[dict[str, Any]]:
    """The things of the next room of the same kind, or of the next of all, as its camera sees them."""
    others = [one for one in truths if one.kind == truth.kind] if truth.kind else []
    others = others if len(others) > 1 else list(truths)
    other = others[(others.index(truth) + 1) % len(others)]
    if other is truth:
        return
    level = level_camera(truth) @ invert_transform(level_camera(other))
    turn = float(np.arctan2(level[1, 0], level[0, 0]))
    for thing in other.list_asked(drawn=False):
        yield describe_thing(thing, transform_points(level, thing.position), thing.size, thing.yaw + turn)


def level_camera(truth: PictureTruth) -> NDArray[np.float64]:
    """Transform (4, 4) from below the camera, x where it looks, to the world: z up, the floor at 0."""
    ahead = truth.pose[:3, 2]
    pose = np.eye(4)
    pose[:3, :3] = yaw_matrix(float(np.arctan2(ahead[1], ahead[0])))
    pose[:2, 3] = truth.pose[:2, 3]
    return pose


def read_depth(path: Path) -> NDArray[np.uint16]:
    """A picture of 16 bits (H, W).

    Raises:
        InputError: it is missing or broken.
    """
    pixels = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if pixels is None or pixels.ndim != 2:
        what = "is missing, or no picture of 16 bits."
        raise InputError(path, what, "make the rooms again", code="E-FILE-UNREADABLE")
    return np.asarray(pixels, np.uint16)
