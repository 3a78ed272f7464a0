"""One-pass matching beside the naive procedure of the official code, on features of the official size.

    python -m benchmarks.matching

Naive: in each of the top-k rounds a fresh `faiss.IndexFlatL2` of all patches of all candidates that remain, searched
with k = 1 (paper A.6, read literally). Ours: `distance_table` and `vote`, as `matching match` calls them. Both in turn
in one process, one thread, on the same synthetic features with many near ties: patches of all pictures crowd around
shared centers.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import faiss
import numpy as np
import torch
from numpy.typing import NDArray

from benchmarks.tables import table
from roomkin.stages.matching.ranking import vote
from roomkin.stages.matching.search import distance_table
from roomkin.stages.matching.searches.torch import affine
from roomkin.stages.plugins import load

CENTERS, SPREAD = 500, 0.6
Features = NDArray[np.float32]


def features(count: int, patches: int, columns: int) -> tuple[Features, Features]:
    """Query (P, D) and candidates (count, P, D): unit vectors around shared centers."""
    rng = np.random.default_rng(0)
    centers = rng.standard_normal((CENTERS, columns), np.float32)

    def picture() -> Features:
        noise = rng.standard_normal((patches, columns), np.float32)
        rows = centers[rng.integers(CENTERS, size=patches)] + np.float32(SPREAD) * noise
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    candidates = np.empty((count, patches, columns), np.float32)
    for candidate in candidates:
        candidate[:] = picture()
    return picture(), candidates


def vote_by_index(query: Features, candidates: Features, rounds: int) -> list[tuple[int, int]]:
    """(picture, votes) of each round: reset, add, search, count, remove the winner."""
    left, picks = np.arange(len(candidates)), []
    index = faiss.IndexFlatL2(query.shape[1])
    for _ in range(rounds):
        index.reset()
        for candidate in left:  # np.delete on the whole, as there, would copy a gigabyte in each round
            index.add(candidates[candidate])
        _, nearest = index.search(query, 1)
        votes = np.bincount(nearest[:, 0] // candidates.shape[1], minlength=len(left))
        winner = int(votes.argmax())
        picks.append((int(left[winner]), int(votes[winner])))
        left = np.delete(left, winner)
    return picks


def vote_by_table(query: Features, candidates: Features, rounds: int, both: bool = False) -> list[tuple[int, int]]:
    """The same picks from one table of distances; `both`: with the way back, as matching has it by default."""
    found = distance_table(query, candidates.__getitem__, len(candidates), "torch", rounds, both)
    return [(pick.group, pick.votes) for pick in vote(found.table, np.arange(len(candidates)), rounds)]


def time_once(function: Callable[[], Any]) -> tuple[float, Any]:
    """CPU seconds of one run, and what it returns."""
    since = time.process_time()
    value = function()
    return time.process_time() - since, value


def sgemm() -> dict[str, float]:
    """CPU seconds of a product of 2048 x 2048 float32 matrices, by every library at hand."""
    a, b = torch.rand(2048, 2048), torch.rand(2048, 2048)
    zero = torch.zeros(2048)
    libraries = {
        "torch.mm (MKL)": lambda: a @ b,
        "numpy (OpenBLAS)": lambda: a.numpy() @ b.numpy(),
        "torch, `affine` (oneDNN)": lambda: affine(a, b, zero),
    }
    return {name: time_once(run)[0] for name, run in libraries.items()}


def speeds(query: Features, candidates: Features, turns: int = 8) -> dict[str, float]:
    """GFLOP/s of the libraries' sgemm and of our search, in turn, as the machine is not ours alone: medians."""
    part = candidates[:: max(1, len(candidates) // 12)][:12]
    work = 2e-9 * len(part) * len(query) * part.shape[1] * part.shape[2]
    measured: dict[str, list[float]] = {}
    for _ in range(turns):
        for name, seconds in sgemm().items():
            measured.setdefault(name, []).append(2e-9 * 2048**3 / seconds)
        for name in ("torch", "faiss"):
            seconds, _ = time_once(partial(load("searches", name), query, part.__getitem__, len(part), False))
            measured.setdefault(f"search `{name}`", []).append(work / seconds)
    return {name: float(np.median(rates)) for name, rates in measured.items()}


def comparisons(asked: argparse.Namespace) -> Iterator[list[Any]]:
    """One row per number of candidates."""
    for count in asked.candidates:
        query, candidates = features(count, asked.patches, asked.columns)
        ours, picks = time_once(partial(vote_by_table, query, candidates, asked.rounds))
        theirs, expected = time_once(partial(vote_by_index, query, candidates, asked.rounds))
        again, _ = time_once(partial(vote_by_table, query, candidates, asked.rounds))
        mutual, _ = time_once(partial(vote_by_table, query, candidates, asked.rounds, both=True))
        agree = sum(a == b for a, b in zip(picks, expected, strict=True))
        ours = (ours + again) / 2
        ratio = f"**{theirs / ours:.1f}**"
        yield [count, f"{theirs:.1f}", f"{ours:.2f}", ratio, f"{agree} of {asked.rounds}", f"{mutual:.2f}"]


def main() -> None:
    """All tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--candidates", type=int, nargs="+", default=[100, 300])
    parser.add_argument("--patches", type=int, default=2352)
    parser.add_argument("--columns", type=int, default=384)
    parser.add_argument("--rounds", type=int, default=10)
    asked = parser.parse_args()
    threads = torch.get_num_threads()
    faiss.omp_set_num_threads(threads)
    rates = speeds(*features(12, asked.patches, asked.columns))
    best = max(rates.values())
    rows = ([name, f"{rate:.0f}", f"{100 * rate / best:.0f} %"] for name, rate in rates.items())
    table([f"float32, {threads} thread(s)", "GFLOP/s", "of the best"], rows)
    rounds = f"naive, {asked.rounds} rounds (CPU s)"
    heading = ["candidates", rounds, "one pass (CPU s)", "ratio", "same picks and votes", "both ways (CPU s)"]
    table(heading, comparisons(asked))


if __name__ == "__main__":
    main()
