"""How well one photograph alone tells camera, places and sizes: open rooms with given masks, no depth.

python -m benchmarks.single_view DIR --half work [--masks exact] [--focal]        DIR: of benchmarks.open_rooms render

--focal: the focal length is known, as EXIF tells it. True depth and true boxes are used to judge alone.
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from benchmarks.open_rooms.pictures import folders, read
from plugins.eyes.proposal import find_border
from plugins.single_view.ends import measure_all
from plugins.single_view.room import build_room, see_camera
from plugins.single_view.supports import find_open, find_supports
from stages.contracts.images import read_rgb

ROOM = {"floor", "wall"}
HEIGHT, TILT, SIZE = 0.12, 3.0, 0.2  # goals: of the camera's height, degrees, of the cube root of the volume


@dataclass(frozen=True)
class Thing:
    """How far a thing is off: its distance and the cube root of its volume, as shares; how its distance was told."""

    distance: float
    size: float
    told: str


@dataclass(frozen=True)
class Camera:
    """How far the camera is off: height and focal length as shares, tilt in degrees."""

    height: float
    tilt: float
    focal: float


def measure(folder: Path, masks: str, with_focal: bool) -> tuple[Camera, list[Thing], float]:
    """The camera and the things of a picture, and CPU seconds."""
    rgb, truth = read_rgb(folder / "rgb.png"), read(folder)
    values = np.asarray(cv2.imread(str(folder / f"{masks}.png"), cv2.IMREAD_UNCHANGED), np.uint16)
    said = {int(value): label for value, label in json.loads((folder / f"{masks}.json").read_text()).items()}
    labels = {value: label for value, label in said.items() if label not in ROOM and (values == value).any()}
    start = time.process_time()
    camera = see_camera(rgb, truth.focal if with_focal else None)
    room = build_room(rgb, camera, values, labels)
    seconds = time.process_time() - start
    ends = measure_all(values, list(labels), ~find_border(rgb))
    on = find_supports(values, labels, ends, camera.view)
    pose, view = truth.pose, room.view
    up = pose[:3, :3].T @ [0, 0, 1]
    tilt = float(np.degrees(np.arccos(np.clip(view.rotation[2] @ up, -1, 1))))
    things = []
    for thing in truth.things:
        if (box := room.boxes.get(thing.number)) is None:
            continue
        far = float(np.linalg.norm(box.center - [0, 0, view.above]) / np.linalg.norm(thing.position - pose[:3, 3]))
        size = float(np.prod(box.size) / np.prod(thing.size)) ** (1 / 3)
        hidden = find_open(thing.number, ends, on)[3]
        told = (
            "wall" if room.on[thing.number] < 0 else "top" if room.on[thing.number] else "hidden" if hidden else "foot"
        )
        things.append(Thing(far - 1, size - 1, told))
    off = Camera(view.above / float(pose[2, 3]) - 1, tilt, view.focal / truth.focal - 1)
    return off, things, seconds


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", default="work")
    parser.add_argument("--masks", choices=["drawn", "exact"], default="drawn")
    parser.add_argument("--focal", action="store_true")
    asked = parser.parse_args()
    found = [measure(folder, asked.masks, asked.focal) for folder in folders(asked.folder, asked.half)]
    cameras, things = [one for one, _, _ in found], [thing for _, each, _ in found for thing in each]
    height, tilt, focal = (np.abs([getattr(one, name) for one in cameras]) for name in ("height", "tilt", "focal"))
    right = f"height within {HEIGHT:.0%}: {(height < HEIGHT).sum()}, tilt within {TILT:.0f}: {(tilt < TILT).sum()}"
    print(f"{len(cameras)} pictures: {right}; median off:")
    print(f"height {np.median(height):.1%}, tilt {np.median(tilt):.1f} degrees, focal length {np.median(focal):.1%}")
    for told in ("foot", "hidden", "top", "wall"):
        of = [thing for thing in things if thing.told == told]
        if of:
            far, size = (np.abs([getattr(thing, name) for thing in of]) for name in ("distance", "size"))
            within = f"size within {SIZE:.0%}: {(size < SIZE).sum()}"
            print(f"{told}: {len(of)} things, distance {np.median(far):.0%} off, {within}")
    print(f"{np.mean([seconds for *_, seconds in found]):.1f} CPU s a picture")


if __name__ == "__main__":
    main()
