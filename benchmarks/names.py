"""How well things are named in pictures of other people's models, and how sure: beside open_rooms/kinds.yaml.

python -m benchmarks.names DIR --half work [--coco FILE] [--fit]

DIR: of benchmarks.open_rooms render. FILE: JSON, by picture and number of a thing what a detector calls it:
{"couch": 0.9}. Beside every thing's exact mask there is one with faults, or a piece of floor or wall, by
plugins/names/training/dirt.py.
"""

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from benchmarks.masks import frame_of
from benchmarks.open_rooms import packs
from benchmarks.open_rooms.pictures import folders, read
from plugins.inputs.rgbd.frame import TILT
from plugins.names.observed import observe
from plugins.names.propose import Weights, combine, gather, read_network
from plugins.names.training.dirt import OTHER, SAME, cut_patch, share_owner, soil
from stages.geometry.cameras import back_project
from stages.geometry.levels import find_ground
from stages.geometry.room_planes import make_floor_frame

Array = NDArray[np.float64]
Words = Mapping[str, Mapping[str, Mapping[str, float]]]
SAMPLES = 2000  # of the bootstrap
SURE = (0.0, 0.3, 0.5, 0.7, 0.9, 1.01)  # bounds of the rows of the table of certainty
NONE = "other"
WITHOUT = {"shape": 0, "ImageNet": 1, "COCO's word": 2}


@dataclass(frozen=True)
class Thing:
    """A mask of a picture; `right`: the names that are right for it; `said` (3, C): see `gather`."""

    model: str
    kind: str
    right: list[str]
    exact: bool
    said: Array


def things_of(folder: Path, words: Words, names: list[str]) -> Iterator[Thing]:
    """The named things of a picture for which any category is right, by exact masks and by ones with faults."""
    rng, frame = np.random.default_rng(0), frame_of(folder)
    exact, depth = cv2.imread(str(folder / "exact.png"), cv2.IMREAD_UNCHANGED), frame.depth.astype(float)
    ground = find_ground(back_project(depth, frame.intrinsics), depth > 0, TILT)
    if ground is None:
        return
    level, things = make_floor_frame(ground), {thing.number: thing for thing in read(folder).things}
    wholes = {number: [exact == number] for number in things if (exact == number).any()}
    owner = np.searchsorted([-1, 0, *wholes], exact).astype(np.uint8)

    def look(mask: NDArray[np.bool_], number: int, clean: bool) -> Thing:
        thing = things.get(number)
        right = packs.kinds()[thing.kind].sensible if thing else [NONE]
        coco = words.get(folder.name, {}).get(str(number)) if thing else None
        said = gather(observe(frame.rgb, depth, mask, frame.intrinsics, level), coco, names)
        return Thing(thing.model if thing else "", thing.kind if thing else NONE, right, clean, said)

    for number, (mask,) in wholes.items():
        if not (things[number].named and packs.kinds()[things[number].kind].sensible):
            continue
        yield look(mask, number, True)
        faulty = soil(mask, owner, rng) if rng.random() < 0.7 else cut_patch(exact == 0, rng)
        found, iou = share_owner(faulty, wholes)
        if faulty.sum() > 60 and not OTHER < iou < SAME:
            yield look(faulty, found if iou >= SAME else 0, False)


def likelihood(share: Array, right: NDArray[np.bool_]) -> float:
    """Mean logarithm of the probabilities (N, C) of the right names (N, C), things and what is none each half of it."""
    each, none = np.log((share * right).sum(axis=1).clip(1e-12)), right[:, -1]
    return float((each[~none].mean() + each[none].mean()) / 2) if none.any() else float(each.mean())


def fit(said: Array, right: NDArray[np.bool_]) -> Weights:
    """The weights by which the right names are most likely."""

    def loss(values: Array) -> float:
        return -likelihood(combine(said, Weights(*values)), right)

    return Weights(*minimize(loss, Weights(), method="Nelder-Mead", options={"maxiter": 800}).x.round(2).tolist())


def interval(right: Array, models: NDArray[np.str_]) -> str:
    """Percent, and 95 % of a bootstrap over models."""
    rng, names = np.random.default_rng(0), np.unique(models)
    sums = np.array([[right[models == name].sum(), (models == name).sum()] for name in names])
    drawn = sums[rng.integers(len(names), size=(SAMPLES, len(names)))].sum(axis=1)
    low, high = np.quantile(drawn[:, 0] / drawn[:, 1], [0.025, 0.975])
    return f"{100 * right.mean():.0f} [{100 * low:.0f}, {100 * high:.0f}]"


def report(title: str, share: Array, right: NDArray[np.bool_], models: NDArray[np.str_]) -> NDArray[np.bool_]:
    """Print how often the surest category is right, and one of three; which surest are."""
    hits = np.take_along_axis(right, np.argsort(-share[:, :-1], axis=1, kind="stable"), axis=1)
    first, three = (interval(one.astype(float), models) for one in (hits[:, 0], hits[:, :3].any(axis=1)))
    print(f"{title}: {first} / {three}, log-likelihood {likelihood(share, right):.2f}")
    return np.asarray(hits[:, 0])


def report_certainty(share: Array, right: NDArray[np.bool_]) -> None:
    """Print what is said of the surest category beside how often it is right, and how none is told from a thing."""
    surest, none = share[:, :-1].max(axis=1), right[:, -1]
    hit = np.take_along_axis(right, share[:, :-1].argmax(axis=1)[:, None], axis=1)[:, 0]
    for low, high in pairwise(SURE):
        if (some := (surest >= low) & (surest < high)).any():
            print(f"surer than {low}: {some.sum()}, said {surest[some].mean():.2f}, right {hit[some].mean():.2f}")
    better = (share[none, -1][:, None] > share[~none, -1]).mean()
    print(f"none: {share[none, -1].mean():.2f} of what is, {share[~none, -1].mean():.2f} of things, apart {better:.2f}")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", default="work")
    parser.add_argument("--coco", type=Path)
    parser.add_argument("--fit", action="store_true")
    asked = parser.parse_args()
    words = json.loads(asked.coco.read_text()) if asked.coco else {}
    _, names = read_network()
    things = [one for folder in folders(asked.folder, asked.half) for one in things_of(folder, words, names)]
    said = np.array([thing.said for thing in things])
    right = np.array([[name in thing.right for name in names] for thing in things])
    models, exact = (np.array([getattr(thing, name) for thing in things]) for name in ("model", "exact"))
    weights = fit(said, right) if asked.fit else Weights()
    print(weights)
    share, real = combine(said, weights), ~right[:, -1]
    print(f"{exact.sum()} things, {(real & ~exact).sum()} of them by faulty masks, {(~real).sum()} masks of none")
    print("first right / one of three right, %, by")
    hit = report("exact masks", share[exact], right[exact], models[exact])
    report("masks with faults", share[real & ~exact], right[real & ~exact], models[real & ~exact])
    for title, row in WITHOUT.items():
        silent = said.copy()
        silent[:, row] = 1 / len(names)
        report(f"without {title}", combine(silent, weights)[exact], right[exact], models[exact])
    report_certainty(share, right)
    surest = share[exact, :-1].argmax(axis=1)
    kinds = np.array([thing.kind for thing in things])[exact]
    wrong = Counter((kind, names[one]) for kind, one, good in zip(kinds, surest, hit, strict=True) if not good)
    print(", ".join(f"{kind} as {name} {count}" for (kind, name), count in wrong.most_common(12)))


if __name__ == "__main__":
    main()
