"""How well pictures are cut into things without a hand: things found beside the exact masks of open rooms.

python -m benchmarks.masks DIR --half work        DIR: of benchmarks.open_rooms render
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from benchmarks.open_rooms.pairs import FOUND, overlaps
from benchmarks.open_rooms.pictures import folders, read
from roomkin.stages.config.perception import SeeSection
from roomkin.stages.contracts import InputError
from roomkin.stages.perception.read.frame import Frame
from roomkin.stages.perception.see import look
from roomkin.stages.perception.segmentation.choosing import choose
from roomkin.stages.perception.segmentation.proposal import list_proposals

SMALL, LARGE = 0.005, 0.05  # shares of the picture


@dataclass(frozen=True)
class ThingScore:
    """A thing of a picture: its best piece's IoU, its share of the picture, whether it is cut by the border, hangs, and
    how many pieces have most of their pixels in it."""

    iou: float
    share: float
    cut: bool
    hangs: bool
    pieces: int


def frame_of(folder: Path) -> Frame:
    """The picture in a folder of open rooms."""
    camera = json.loads((folder / "intrinsics.json").read_text())
    matrix = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1.0]])
    rgb = np.asarray(cv2.imread(str(folder / "rgb.png"))[..., ::-1], np.uint8)
    depth = cv2.imread(str(folder / "depth.png"), cv2.IMREAD_UNCHANGED).astype(np.float32) / 1000
    return Frame(rgb, depth, matrix)


def measure(folder: Path, proposers: list[str]) -> tuple[list[ThingScore], int, int, int, float]:
    """The named things of a picture, how many pieces were cut, how many of them can be judged, how many are a thing,
    and seconds. A piece most of which shows what nobody named, neither thing nor floor nor wall, cannot be judged."""
    exact = cv2.imread(str(folder / "exact.png"), cv2.IMREAD_UNCHANGED).astype(np.uint16)
    start = time.process_time()
    values = np.zeros_like(exact)
    try:
        view = look(frame_of(folder))
        for number, thing in enumerate(choose(view, list_proposals(view, SeeSection(), proposers)), 1):
            values[thing.mask] = number
    except InputError:
        pass  # it shows nothing level
    seconds = time.process_time() - start
    iou, inside = overlaps(exact, values)
    named = [thing for thing in read(folder).things if thing.named]
    found = []
    for thing in named:
        row, held = iou[thing.number, 1:], inside[thing.number, 1:]
        best = float(row.max()) if len(row) else 0.0
        hangs = thing.support == "wall"
        found.append(ThingScore(best, thing.pixels / exact.size, thing.cut, hangs, int((held > FOUND).sum())))
    rows = [thing.number for thing in named]
    right = int((iou[rows].max(axis=0)[1:] > FOUND).sum()) if rows and iou.shape[1] > 1 else 0
    judged = int((inside[1:, 1:].sum(axis=0) > 0.5).sum())
    return found, len(np.unique(values[values > 0])), judged, right, seconds


def summarise(things: list[ThingScore], pieces: int, judged: int, right: int) -> dict[str, str]:
    """Columns of the table."""

    def recall(some: list[ThingScore]) -> str:
        return f"{sum(thing.iou > FOUND for thing in some)} / {len(some)}"

    return {
        "recall": recall(things),
        "pieces": str(pieces),
        "precision": f"{right} / {judged}",
        "pieces a thing": f"{np.mean([thing.pieces for thing in things]):.2f}",
        "small": recall([thing for thing in things if thing.share < SMALL]),
        "middle": recall([thing for thing in things if SMALL <= thing.share < LARGE]),
        "large": recall([thing for thing in things if thing.share >= LARGE]),
        "cut": recall([thing for thing in things if thing.cut]),
        "hanging": recall([thing for thing in things if thing.hangs]),
    }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", default="work")
    parser.add_argument("--proposers", nargs="+", default=SeeSection().proposers)
    asked = parser.parse_args()
    results = [measure(folder, asked.proposers) for folder in folders(asked.folder, asked.half)]
    things = [thing for each, *_ in results for thing in each]
    row = summarise(things, *(sum(result[k] for result in results) for k in (1, 2, 3)))
    row["CPU s a picture"] = f"{np.mean([result[4] for result in results]):.1f}"
    print(f"{len(results)} pictures\n\n| {' | '.join(row)} |\n|{'---|' * len(row)}\n| {' | '.join(row.values())} |")


if __name__ == "__main__":
    main()
