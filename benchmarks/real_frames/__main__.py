"""Real frames: what is found and called rightly, and what stands for it in scenes, by what is given beside the picture.

python -m benchmarks.real_frames DATA OUT --library results [--given depth|outlines|nothing]

depth: no hand (`eyes see`). outlines: depth, the masks below and the first name of each. nothing: not even depth.

DATA: `uois_realsense_tabletop`, the nine pictures in `example_images` of github.com/chrisdxie/uois (MIT). Beside this
file are masks of 33 things in them (by plane and DBSCAN, where one shows one thing that the library has) and
`names.json`, the categories that are sensible for each, said by hand. Goes on where it was stopped.
"""

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benchmarks.open_rooms.pairs import overlaps, pair_pieces
from benchmarks.open_rooms.run import (
    ONE_RANK,
    Shelves,
    StoppedError,
    extract_objects,
    log_stage,
    make_config,
    place_cousins,
    shelves,
)
from benchmarks.open_rooms.tables import table
from roomkin.stages.config.model import Config
from roomkin.stages.contracts import Cousins, GeneratedScene, Objects, read_json
from roomkin.stages.contracts.scene_input import read_annotations
from roomkin.stages.contracts.things import THINGS, Things
from roomkin.stages.perception import draw, from_rgbd, see

HERE = Path(__file__).parent
NAMES: dict[str, dict[str, list[str]]] = json.loads((HERE / "names.json").read_text())  # sensible, by frame and mask
CAMERA = ("612.937", "613.173", "322.549", "248.158")  # fx, fy, cx, cy in pixels


@dataclass(frozen=True)
class FrameThing:
    """A thing of a frame: whether an outline shows it, its first name or one of three is right, it is placed, and its
    cousin is sensible."""

    shown: bool = False
    first: bool = False
    three: bool = False
    placed: bool = False
    sensible: bool = False


def score_frame(name: str, out: Path) -> tuple[list[FrameThing], int]:
    """The things of a frame that was reconstructed into a folder, and how many were found."""
    truth = NAMES[name]
    exact = np.asarray(cv2.imread(str(HERE / f"{name}.png"), cv2.IMREAD_UNCHANGED), np.uint16)
    annotations, masks = read_annotations(out / "input" / "annotations.json")
    said = {item.mask: ([item.label], True) for item in annotations.objects}  # names, best first; whether placed
    if (out / "input" / THINGS).is_file():
        things = read_json(Things, out / "input" / THINGS).things
        said = {item.mask: ([one.name for one in item.names[:3]], not item.left_out) for item in things}
    pieces = np.where(np.isin(masks, list(said)), masks, 0).astype(np.uint16)
    pairs = pair_pieces(map(int, truth), overlaps(exact, pieces)[0])
    ids = {item.mask: item.id for item in read_json(Objects, out / "objects.json").objects}
    cousins = {one.id: one.cousins for one in read_json(Cousins, out / "geometry" / "cousins.json").objects}
    found = []
    for number, sensible in truth.items():
        if (value := pairs.get(int(number))) is None:
            found.append(FrameThing())
            continue
        names, placed = said[value]
        right = [name.replace(" ", "_") in sensible for name in names]
        best = cousins.get(ids.get(value, ""), [])
        is_sensible = bool(best) and best[0].category in sensible
        found.append(FrameThing(True, right[:1] == [True], any(right), placed, is_sensible))
    return found, len(said)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--library", type=Path, default=Path("results"))
    parser.add_argument("--given", choices=["depth", "outlines", "nothing"], default="depth")
    asked = parser.parse_args()
    config = make_config()
    shelf = shelves(asked.library, config)
    lines, every, stands = [], list[FrameThing](), list[bool]()
    for rgb in sorted(asked.data.glob("*_color.png")):
        name = rgb.name.removesuffix("_color.png")
        out = asked.out / asked.given / name
        out.mkdir(parents=True, exist_ok=True)
        try:
            reconstruct(asked.given, rgb, out, config, shelf)
        except StoppedError as stopped:
            print(f"{name}: {stopped}", file=sys.stderr)
            found, pieces = [FrameThing()] * len(NAMES[name]), 0
        else:
            found, pieces = score_frame(name, out)
            check = read_json(GeneratedScene, out / "geometry" / "scene_1.json").plausibility
            stands.append(check is not None and not check.fallen)
        every += found
        lines.append([name, str(pieces), *count(found)])
    print(table(["frame", "things", "found", "first name right", "one of three", "placed", "sensible"], iter(lines)))
    print(" ".join(count(every)), f"; {sum(stands)} of {len(stands)} scenes stand")


def reconstruct(given: str, rgb: Path, out: Path, config: Config, shelf: Shelves) -> None:
    """Write a frame's input folder, objects, cousins and scene, what is not there yet."""
    name, entry, objects = rgb.name.removesuffix("_color.png"), out / "input", out / "objects.json"
    if not objects.is_file():
        with log_stage(out / "extraction.log"):
            write_input(given, rgb, out, entry)
            extract_objects(entry, f"frame_{name}", objects, config)
    place_cousins(entry, objects, out, "geometry", config, shelf, ONE_RANK)


def write_input(given: str, rgb: Path, out: Path, entry: Path) -> None:
    """Write the input folder of a frame."""
    name = rgb.name.removesuffix("_color.png")
    if given == "nothing":
        draw.run(image=rgb, out=entry)
        return
    frame: dict[str, Any] = {"rgb": rgb, "depth": rgb.with_name(f"{name}_depth.png"), "unit": "mm", "camera": CAMERA}
    if given == "outlines":
        said = {number: right[0].replace("_", " ") for number, right in NAMES[name].items()}
        labels = out / "labels.json"
        labels.write_text(json.dumps(said), encoding="utf-8")
        from_rgbd.run(out=entry, masks=HERE / f"{name}.png", labels=labels, **frame)
    else:
        from_rgbd.run(out=out / "view", **frame)
        see.run(picture=out / "view", out=entry)


def count(found: list[FrameThing]) -> list[str]:
    """Of how many things each is so."""
    return [f"{sum(getattr(one, what) for one in found)} / {len(found)}" for what in FrameThing.__dataclass_fields__]


if __name__ == "__main__":
    main()
