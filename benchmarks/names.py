"""How well things are named that exact masks show: names proposed, beside the sensible ones of open_rooms/kinds.yaml.

python -m benchmarks.names DIR --half work        DIR: of benchmarks.open_rooms render; --fit: with the weight of
looks that was chosen on the other rooms of the half, as that of `plugins.names.propose.WEIGHTS` was on all of `work`
"""

import argparse
from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.masks import frame_of
from benchmarks.open_rooms import packs
from benchmarks.open_rooms.pictures import folders, read
from plugins.inputs.rgbd.pieces import TILT
from plugins.names.observed import Observed, observe
from plugins.names.propose import WEIGHTS, read_table, say
from plugins.segmenter.ground import find_ground
from stages.geometry.cameras import back_project
from stages.geometry.room_planes import make_floor_frame

Array = NDArray[np.float64]
LOOKS = np.arange(0, 1.01, 0.05)  # weights that are tried
SAMPLES = 2000  # of the bootstrap
SURE = (0.0, 0.3, 0.5, 0.7, 0.9, 1.01)  # bounds of the rows of the table of certainty


@dataclass(frozen=True)
class Thing:
    """A named thing of a picture; `sensible`: the categories that are right for it."""

    picture: str
    model: str
    kind: str
    sensible: list[str]
    observed: Observed


def things_of(folder: Path) -> list[Thing]:
    """The named things of a picture for which any category is right."""
    frame, exact = frame_of(folder), cv2.imread(str(folder / "exact.png"), cv2.IMREAD_UNCHANGED)
    depth, found = frame.depth.astype(float), []
    ground = find_ground(back_project(depth, frame.intrinsics), depth > 0, TILT)
    if ground is None:
        return []
    level = make_floor_frame(ground)
    for thing in read(folder).things:
        mask, sensible = exact == thing.number, packs.kinds()[thing.kind].sensible
        if thing.named and sensible and mask.any():
            seen = observe(frame.rgb, depth, mask, frame.intrinsics, level)
            found.append(Thing(folder.name, thing.model, thing.kind, sensible, seen))
    return found


def share_names(said: Array, looks: float) -> Array:
    """How sure each name is (N, C) by log-likelihoods (N, K, C), the first of which has a weight."""
    total = looks * said[:, 0] + said[:, 1:].sum(axis=1)
    share = np.exp(total - total.max(axis=1, keepdims=True))
    return np.asarray(share / share.sum(axis=1, keepdims=True))


def choose_looks(said: Array, right: NDArray[np.bool_]) -> float:
    """The weight of looks by which the right names (N, C) are most likely."""

    def loss(looks: float) -> float:
        return -float(np.log((share_names(said, looks) * right).sum(axis=1).clip(1e-12)).mean())

    return float(min(LOOKS, key=loss))


def interval(right: Array, models: NDArray[np.str_]) -> str:
    """Percent, and 95 % of a bootstrap over models."""
    rng, names = np.random.default_rng(0), np.unique(models)
    sums = np.array([[right[models == name].sum(), (models == name).sum()] for name in names])
    drawn = sums[rng.integers(len(names), size=(SAMPLES, len(names)))].sum(axis=1)
    low, high = np.quantile(drawn[:, 0] / drawn[:, 1], [0.025, 0.975])
    return f"{100 * right.mean():.0f} [{100 * low:.0f}, {100 * high:.0f}]"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", default="work")
    parser.add_argument("--fit", action="store_true")
    asked = parser.parse_args()
    things = [thing for folder in folders(asked.folder, asked.half) for thing in things_of(folder)]
    names, pictures = list(read_table().names), np.array([thing.picture for thing in things])
    said = np.array([say(thing.observed, read_table()) for thing in things])
    right = np.array([[name in thing.sensible for name in names] for thing in things])
    if asked.fit:
        print(f"looks weigh {choose_looks(said, right):.2f}")
        share = np.zeros(right.shape)
        for picture in np.unique(pictures):
            one = pictures == picture
            share[one] = share_names(said[one], choose_looks(said[~one], right[~one]))
    else:
        share = share_names(said, WEIGHTS[0])
    order = np.argsort(-share, axis=1, kind="stable")
    hits = np.take_along_axis(right, order, axis=1)
    models = np.array([thing.model for thing in things])
    print(f"{len(things)} things; first right, one of three right, %:")
    print(interval(hits[:, 0].astype(float), models), interval(hits[:, :3].any(axis=1).astype(float), models))
    surest = share.max(axis=1)
    for low, high in pairwise(SURE):
        if (some := (surest >= low) & (surest < high)).any():
            print(f"surer than {low}: {some.sum()}, said {surest[some].mean():.2f}, right {hits[some, 0].mean():.2f}")
    wrong = Counter(
        (thing.kind, names[row[0]]) for thing, row, hit in zip(things, order, hits, strict=True) if not hit[0]
    )
    print(", ".join(f"{kind} as {name} {count}" for (kind, name), count in wrong.most_common(12)))


if __name__ == "__main__":
    main()
