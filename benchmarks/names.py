"""How well outlines are named in pictures of other people's models, and how sure: beside plugins/scorecard/kinds.yaml.

python -m benchmarks.names DIR --half work [--kept learning] [--fit]

DIR: of benchmarks.open_rooms render. Three kinds of outlines: the exact ones; those with faults, of pieces of floor and
wall too (benchmarks/name_training/dirt.py); and those that the pipeline finds itself.
"""

import argparse
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import minimize

from benchmarks.name_training.looks import share_out_of_fold
from benchmarks.name_training.outlines import EXACT, FAULTY, OWN, join, see_outlines
from benchmarks.open_rooms.pictures import folders
from roomkin.stages.perception.classification.propose import Exponents, combine, read_head, read_network

Array = NDArray[np.float64]
SAMPLES = 2000  # of the bootstrap
SURE = (0.0, 0.3, 0.5, 0.7, 0.9, 1.01)  # bounds of the rows of the table of certainty
WITHOUT = ("shape", "ImageNet", "COCO's word", "CLIP")


def likelihood(share: Array, right: NDArray[np.bool_]) -> float:
    """Mean logarithm of the probabilities (N, C) of the right names (N, C), things and what is none each half of it."""
    each, none = np.log((share * right).sum(axis=1).clip(1e-12)), right[:, -1]
    return float((each[~none].mean() + each[none].mean()) / 2) if none.any() else float(each.mean())


def fit(said: Array, right: NDArray[np.bool_]) -> Exponents:
    """The weights by which the right names are most likely."""

    def loss(values: Array) -> float:
        return -likelihood(combine(said, Exponents(*values)), right)

    return Exponents(*minimize(loss, Exponents(), method="Nelder-Mead", options={"maxiter": 800}).x.round(2).tolist())


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
    parser.add_argument("--kept", default="pictures", help="or learning: those to learn from")
    parser.add_argument("--fit", action="store_true", help="weights of voices; CLIP's by models that it has not seen")
    asked = parser.parse_args()
    torch.set_num_threads(1)
    _, names = read_network()
    every = [see_outlines(folder, asked.folder / "seen") for folder in folders(asked.folder, asked.half, asked.kept)]
    seen = join([one for one in every if one is not None])
    right = seen.right(names)
    if asked.fit:
        looks = share_out_of_fold(seen, right)
    else:
        with torch.inference_mode():
            looks = read_head()[0](torch.from_numpy(seen.looks)).double().softmax(dim=1).numpy()
    said = np.concatenate([seen.said, looks[:, None]], axis=1)
    own = seen.how == OWN
    weights = fit(said[own], right[own]) if asked.fit else Exponents()
    print(weights)
    share, real = combine(said, weights), ~right[:, -1]
    print("first right / one of three right, %, by")
    for title, how in (("exact outlines", EXACT), ("outlines with faults", FAULTY), ("our own outlines", OWN)):
        some = real & (seen.how == how)
        report(f"{some.sum()} {title}", share[some], right[some], seen.model[some])
    some = real & (seen.how == EXACT)
    for row, title in enumerate(WITHOUT):
        silent = said.copy()
        silent[:, row] = 1 / len(names)
        report(f"without {title}", combine(silent, weights)[some], right[some], seen.model[some])
    report_certainty(share[own], right[own])
    surest = share[some, :-1].argmax(axis=1)
    hit = np.take_along_axis(right[some], surest[:, None], axis=1)[:, 0]
    told = zip(seen.kind[some], surest, hit, strict=True)
    wrong = Counter((kind, names[one]) for kind, one, good in told if not good)
    print(", ".join(f"{kind} as {name} {count}" for (kind, name), count in wrong.most_common(12)))


if __name__ == "__main__":
    main()
