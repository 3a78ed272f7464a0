"""Means over many objects, and their intervals: objects are resampled, and families of assets across them.

A side is a table of successes with a row per rollout: `object`, `family`, `asset`, `seed`, `success` in [0, 1]. Objects
weigh alike, and so do the rollouts of one object.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import stdtrit

from stages.config.tables import TablesConfig
from stages.tables.intervals import quantiles
from stages.tables.statistics import NAN, Interval

ROLLOUT = ["object", "family", "asset", "seed"]
CHUNK = 250  # resamples at once, so that memory stays small


class Estimate(NamedTuple):
    """A mean over objects.

    low, high: its interval by objects and families. crossed: that of a bootstrap of objects, families and runs, which
    counts the chance of a single rollout once for each of the three and so is wider than need be.
    """

    objects: int
    families: int
    rollouts: int
    mean: float
    low: float
    high: float
    crossed: Interval


def pair_cells(ours: pd.DataFrame, theirs: pd.DataFrame) -> pd.DataFrame:
    """`success` of ours minus theirs, for the same asset of the same object and the same training seed."""
    both = ours.merge(theirs, on=ROLLOUT, suffixes=("", "_theirs"))
    return both[ROLLOUT].assign(success=both["success"].astype(float) - both["success_theirs"].astype(float))


def estimate(rows: pd.DataFrame, options: TablesConfig) -> Estimate:
    """The mean of a side or of a paired difference. Below two objects or families there is no interval."""
    objects, families = rows["object"].nunique(), rows["family"].nunique()
    if rows.empty:
        return Estimate(0, 0, 0, NAN, NAN, NAN, Interval(NAN, NAN))
    mean = float(rows.groupby("object")["success"].mean().mean())
    if min(objects, families) < 2:
        return Estimate(objects, families, len(rows), mean, NAN, NAN, Interval(NAN, NAN))
    half = standard_error(rows) * stdtrit(min(objects, families) - 1, (1 + options.confidence) / 2)
    crossed = quantiles(resample_means(rows, options), options)
    return Estimate(objects, families, len(rows), mean, mean - half, mean + half, crossed)


def standard_error(rows: pd.DataFrame) -> float:
    """Of the mean over objects, clustered in two ways: by object and by family.

    The variance is that between objects plus that between families minus that between their pairs, which both hold
    (Cameron, Gelbach and Miller, "Robust inference with multiway clustering", Journal of Business & Economic Statistics
    29 (2011) 238-249); never less than that between objects. Policies are trained for one object each, so objects bring
    their runs with them.
    """
    means = rows.groupby("object")["success"].mean()
    weights = 1 / (len(means) * rows.groupby("object")["success"].transform("size"))
    shares = (weights * (rows["success"] - means.mean())).to_numpy()

    def sum_squares(*names: str) -> float:
        sums = pd.Series(shares).groupby([rows[name].to_numpy() for name in names]).sum()
        return float((sums**2).sum() * len(sums) / (len(sums) - 1))

    objects = sum_squares("object")
    return float(np.sqrt(max(objects + sum_squares("family") - sum_squares("object", "family"), objects)))


def resample_means(rows: pd.DataFrame, options: TablesConfig) -> NDArray[np.float64]:
    """Means of resamples in which objects, families and runs are drawn, crossed."""
    rng = np.random.default_rng(options.seed)
    codes = [pd.factorize(rows[name])[0] for name in ("object", "family", "seed")]
    sizes = [int(code.max()) + 1 for code in codes]
    weights = 1 / np.bincount(codes[0])[codes[0]]
    cube, success = np.zeros(sizes), np.zeros(sizes)
    np.add.at(cube, tuple(codes), weights)
    np.add.at(success, tuple(codes), weights * rows["success"].to_numpy(dtype=float))
    found: list[NDArray[np.float64]] = []
    for first in range(0, options.bootstrap_samples, CHUNK):
        count = min(CHUNK, options.bootstrap_samples - first)
        draws = [rng.multinomial(size, np.full(size, 1 / size), size=count).astype(float) for size in sizes]
        sums = [_sum_weighted(values, draws) for values in (success, cube)]
        found.append(np.divide(sums[0], sums[1], out=np.full(count, NAN), where=sums[1] > 0))
    means = np.concatenate(found)
    return means[~np.isnan(means)]


def _sum_weighted(cube: NDArray[np.float64], draws: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Sums of a cube (objects, families, runs) under draws (S, objects), (S, families), (S, runs)."""
    objects, families, runs = draws
    by_run = (objects @ cube.reshape(len(cube), -1)).reshape(-1, *cube.shape[1:])
    return np.asarray(np.einsum("sfr,sf,sr->s", by_run, families, runs, optimize=True))
