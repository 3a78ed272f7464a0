"""Real frames without a hand: what `eyes see` finds and calls them, and what stands for them in scenes.

python -m benchmarks.real_frames DATA OUT --library results

DATA: `uois_realsense_tabletop`, the nine pictures in `example_images` of github.com/chrisdxie/uois (MIT). Beside this
file are masks of 33 things in them (by plane and DBSCAN, where one shows one thing that the library has) and
`names.json`, the categories that are sensible for each, said by hand. Goes on where it was stopped.
"""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from benchmarks.open_rooms.pairs import overlaps, pair_pieces
from benchmarks.open_rooms.run import ONE_RANK, extract_objects, log_stage, make_config, place_cousins, shelves
from benchmarks.open_rooms.tables import table
from plugins.eyes import see
from plugins.inputs import from_rgbd
from stages.contracts import Cousins, Objects, read_json
from stages.contracts.scene_input import read_annotations
from stages.contracts.things import THINGS, Things

HERE = Path(__file__).parent
CAMERA = ("612.937", "613.173", "322.549", "248.158")  # fx, fy, cx, cy in pixels


@dataclass(frozen=True)
class Found:
    """A thing of a frame: whether an outline shows it, its first name or one of three is right, it is placed, and its
    cousin is sensible."""

    shown: bool = False
    first: bool = False
    three: bool = False
    placed: bool = False
    sensible: bool = False


def score_frame(name: str, out: Path) -> tuple[list[Found], int]:
    """The things of a frame that was reconstructed into a folder, and how many were found."""
    truth: dict[str, list[str]] = json.loads((HERE / "names.json").read_text())[name]
    exact = np.asarray(cv2.imread(str(HERE / f"{name}.png"), cv2.IMREAD_UNCHANGED), np.uint16)
    _, masks = read_annotations(out / "input" / "annotations.json")
    items = {item.mask: item for item in read_json(Things, out / "input" / THINGS).things}
    pieces = np.where(np.isin(masks, list(items)), masks, 0).astype(np.uint16)
    pairs = pair_pieces(map(int, truth), overlaps(exact, pieces)[0])
    ids = {item.mask: item.id for item in read_json(Objects, out / "objects.json").objects}
    cousins = {one.id: one.cousins for one in read_json(Cousins, out / "geometry" / "cousins.json").objects}
    found = []
    for number, sensible in truth.items():
        if (value := pairs.get(int(number))) is None:
            found.append(Found())
            continue
        right = [one.name.replace(" ", "_") in sensible for one in items[value].names[:3]]
        best = cousins.get(ids.get(value, ""), [])
        is_sensible = bool(best) and best[0].category in sensible
        found.append(Found(True, right[:1] == [True], any(right), not items[value].left_out, is_sensible))
    return found, len(items)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--library", type=Path, default=Path("results"))
    asked = parser.parse_args()
    config = make_config()
    shelf = shelves(asked.library, config)
    lines, every = [], list[Found]()
    for rgb in sorted(asked.data.glob("*_color.png")):
        name = rgb.name.removesuffix("_color.png")
        out = asked.out / name
        out.mkdir(parents=True, exist_ok=True)
        entry, objects = out / "input", out / "objects.json"
        if not objects.is_file():
            depth = rgb.with_name(f"{name}_depth.png")
            with log_stage(out / "extraction.log"):
                from_rgbd.run(out=out / "view", rgb=rgb, depth=depth, unit="mm", camera=CAMERA)
                see.run(picture=out / "view", out=entry)
                extract_objects(entry, f"frame_{name}", objects, config)
        place_cousins(entry, objects, out, "geometry", config, shelf, ONE_RANK)
        found, pieces = score_frame(name, out)
        every += found
        lines.append([name, str(pieces), *count(found)])
    print(table(["frame", "things", "found", "first name right", "one of three", "placed", "sensible"], iter(lines)))
    print(" ".join(count(every)))


def count(found: list[Found]) -> list[str]:
    """Of how many things each is so."""
    return [f"{sum(getattr(one, what) for one in found)} / {len(found)}" for what in Found.__dataclass_fields__]


if __name__ == "__main__":
    main()
