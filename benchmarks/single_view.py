"""How well one photograph alone tells camera, places and sizes: open rooms without their depth.

python -m benchmarks.single_view DIR --half work [--masks exact|none] [--focal]    DIR: of benchmarks.open_rooms render

--masks none: nothing is given, no outline, no name. --focal: the focal length is known, as EXIF tells it. True boxes
are used to judge alone.
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.open_rooms import packs
from benchmarks.open_rooms.pairs import overlaps, pair_pieces
from benchmarks.open_rooms.pictures import folders, read, read_masks
from roomkin.stages.config.perception import DrawOptions
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.categories import category_in
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.perception.camera.perspective import angles_of
from roomkin.stages.perception.draw import draw_picture
from roomkin.stages.perception.layout.ends import FLOOR, find_open, measure_all
from roomkin.stages.perception.layout.room import FittedRoom, Spread, arrange, build_room, see_camera
from roomkin.stages.perception.segmentation.proposal import find_border

ROOM = {"floor", "wall"}
HEIGHT, TILT, SIZE = 0.12, 3.0, 0.2  # goals: of the camera's height, degrees, of the cube root of the volume


@dataclass(frozen=True)
class ThingMiss:
    """How far a thing is off: its distance and the cube root of its volume, as shares; how its distance was told."""

    distance: float
    size: float
    told: str


@dataclass(frozen=True)
class FoundRoom:
    """A room, its masks (H, W) and labels, and which of these shows which thing, by its number."""

    room: FittedRoom
    masks: NDArray[np.uint16]
    labels: dict[int, str]
    pairs: dict[int, int]


@dataclass(frozen=True)
class Counts:
    """Things that a person would name, things drawn, and those of the first that are drawn under a sensible name."""

    asked: int
    drawn: int
    named: int


@dataclass(frozen=True)
class CameraError:
    """How far the camera is off: height and focal length as shares, tilt in degrees, roll included; each of them (how
    far it looks down) in its spreads.
    """

    height: float
    tilt: float
    focal: float
    in_spreads: Spread


def find_given(folder: Path, masks: str, focal: float | None) -> FoundRoom:
    """The room of a picture with given masks and labels."""
    rgb = read_rgb(folder / "rgb.png")
    values = np.asarray(cv2.imread(str(folder / f"{masks}.png"), cv2.IMREAD_UNCHANGED), np.uint16)
    said = {int(value): label for value, label in json.loads((folder / f"{masks}.json").read_text()).items()}
    labels = {value: label for value, label in said.items() if label not in ROOM and (values == value).any()}
    room = build_room(rgb, arrange(see_camera(rgb, focal), values, labels, ~find_border(rgb)), values)
    return FoundRoom(room, values, labels, {value: value for value in room.boxes})


def find_alone(folder: Path, focal: float | None, sure: float) -> FoundRoom:
    """The room of a picture with nothing given; its things by the numbers of those that they show."""
    drawn = draw_picture(folder.name, read_rgb(folder / "rgb.png"), focal, DrawOptions(sure=sure))
    shown = np.where(np.isin(drawn.masks, list(drawn.room.boxes)), drawn.masks, 0).astype(np.uint16)
    numbers = [thing.number for thing in read(folder).things if thing.named]
    pairs = pair_pieces(numbers, overlaps(read_masks(folder), shown)[0])
    return FoundRoom(drawn.room, drawn.masks, drawn.labels, pairs)


def measure(
    folder: Path, masks: str, with_focal: bool, sure: float
) -> tuple[CameraError, list[ThingMiss], Counts, float]:
    """The camera and the things of a picture, how many were asked for, drawn and rightly named, and CPU seconds."""
    truth, start = read(folder), time.process_time()
    focal = truth.focal if with_focal else None
    asked = sum(thing.named for thing in truth.things)
    try:
        found = find_alone(folder, focal, sure) if masks == "none" else find_given(folder, masks, focal)
    except InputError:  # nothing is known there
        far = Spread(np.inf, np.inf, np.inf)
        return CameraError(*far, far), [], Counts(asked, 0, 0), time.process_time() - start
    seconds, room, pose = time.process_time() - start, found.room, truth.pose
    ends = measure_all(found.masks, list(found.labels), ~find_border(read_rgb(folder / "rgb.png")))
    up = pose[:3, :3].T @ [0, 0, 1]
    tilt = float(np.degrees(np.arccos(np.clip(room.view.rotation[2] @ up, -1, 1))))
    things, named = [], 0
    for thing in truth.things:
        value = found.pairs.get(thing.number, 0)
        if not value or value not in room.boxes:
            continue
        box = room.boxes[value]
        away = float(np.linalg.norm(box.center - [0, 0, room.view.above]))
        size = float(np.prod(box.size) / np.prod(thing.size)) ** (1 / 3)
        hidden = find_open(value, ends, {key: room.on.get(key, FLOOR) for key in ends})[3]
        told = "wall" if room.on[value] < 0 else "top" if room.on[value] else "hidden" if hidden else "foot"
        things.append(ThingMiss(away / float(np.linalg.norm(thing.position - pose[:3, 3])) - 1, size - 1, told))
        named += category_in(found.labels[value]) in packs.kinds()[thing.kind].sensible
    high, focal = room.view.above / float(pose[2, 3]), room.view.focal / truth.focal
    apart = np.abs([angles_of(room.view.rotation)[1] - angles_of(pose[:3, :3])[1], np.log(high), np.log(focal)])
    off = CameraError(high - 1, tilt, focal - 1, Spread(*apart / room.spread))
    return off, things, Counts(asked, len(room.boxes), named), seconds


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", default="work")
    parser.add_argument("--masks", choices=["drawn", "exact", "none"], default="drawn")
    parser.add_argument("--focal", action="store_true")
    parser.add_argument("--sure", type=float, default=DrawOptions().sure)
    asked = parser.parse_args()
    found = [measure(folder, asked.masks, asked.focal, asked.sure) for folder in folders(asked.folder, asked.half)]
    cameras, things = [one for one, *_ in found], [thing for _, each, *_ in found for thing in each]
    counts = [each for *_, each, _ in found]
    height, tilt, focal = (np.abs([getattr(one, name) for one in cameras]) for name in ("height", "tilt", "focal"))
    right = f"height within {HEIGHT:.0%}: {(height < HEIGHT).sum()}, tilt within {TILT:.0f}: {(tilt < TILT).sum()}"
    print(f"{len(cameras)} pictures: {right}; median off:")
    print(f"height {np.median(height):.1%}, tilt {np.median(tilt):.1f} degrees, focal length {np.median(focal):.1%}")
    for name in Spread._fields:
        apart = np.array([getattr(one.in_spreads, name) for one in cameras])
        print(f"{name} within its spread: {(apart < 1).mean():.0%}, within two: {(apart < 2).mean():.0%}")
    for told in ("foot", "hidden", "top", "wall"):
        of = [thing for thing in things if thing.told == told]
        if of:
            far, size = (np.abs([getattr(thing, name) for thing in of]) for name in ("distance", "size"))
            within = f"size within {SIZE:.0%}: {(size < SIZE).sum()}"
            print(f"{told}: {len(of)} things, distance {np.median(far):.0%} off, {within}")
    asked_for, drawn, named = (sum(getattr(one, name) for one in counts) for name in ("asked", "drawn", "named"))
    print(f"{asked_for} things to name, {len(things)} found, {named} with a sensible name, {drawn} drawn")
    print(f"{np.mean([seconds for *_, seconds in found]):.1f} CPU s a picture")


if __name__ == "__main__":
    main()
