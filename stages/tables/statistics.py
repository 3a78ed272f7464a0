"""Means, standard deviations and intervals of the tables. NaN stands for 'cannot be said'."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

NAN = float("nan")


class Interval(NamedTuple):
    """Ends of a confidence interval."""

    low: float
    high: float


def present(values: ArrayLike) -> NDArray[np.float64]:
    """The values that are there (None and NaN dropped), float64."""
    array = np.asarray(values, dtype=np.float64).ravel()
    return array[~np.isnan(array)]


def mean(values: ArrayLike) -> float:
    """Mean of the values that are there; NaN if there is none."""
    array = present(values)
    return float(array.mean()) if array.size else NAN


def std(values: ArrayLike) -> float:
    """Sample standard deviation (ddof = 1) of the values that are there; NaN below two values."""
    array = present(values)
    return float(array.std(ddof=1)) if array.size > 1 else NAN


def t_interval(values: ArrayLike, confidence: float) -> Interval:
    """Student's t interval of the mean.

    A scene has 5 to 15 objects: at that size it covers better than a percentile bootstrap, and it needs no seed.
    """
    array = present(values)
    if array.size < 2:
        return Interval(NAN, NAN)
    half = stats.t.ppf((1 + confidence) / 2, array.size - 1) * array.std(ddof=1) / np.sqrt(array.size)
    return Interval(float(array.mean() - half), float(array.mean() + half))


def wilson(successes: int, episodes: int, confidence: float) -> Interval:
    """Wilson score interval of a success rate."""
    if episodes == 0:
        return Interval(NAN, NAN)
    interval = stats.binomtest(int(successes), int(episodes)).proportion_ci(confidence, method="wilson")
    return Interval(float(interval.low), float(interval.high))


def difference_interval(
    ours: NDArray[np.float64], baseline: NDArray[np.float64], confidence: float, samples: int, seed: int
) -> Interval:
    """Bootstrap interval of mean(ours) - mean(baseline), paired by initial state.

    Args:
        ours, baseline: (runs, states) successes in {0, 1}; column s is the same initial state in both.

    Each resample draws initial states, shared by both sides, and the runs of each side. With a single run there is
    nothing to draw: the interval then speaks of these trained policies, not of training again.
    """
    rng = np.random.default_rng(seed)
    states = ours.shape[1]

    def weights(count: int) -> NDArray[np.float64]:
        return rng.multinomial(count, np.full(count, 1 / count), size=samples) / count

    by_state = weights(states)
    rates = [np.einsum("br,rs,bs->b", weights(len(side)), side, by_state, optimize=True) for side in (ours, baseline)]
    low, high = np.quantile(rates[0] - rates[1], [(1 - confidence) / 2, (1 + confidence) / 2])
    return Interval(float(low), float(high))
