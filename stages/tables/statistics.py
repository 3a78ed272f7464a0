"""Means, standard deviations and intervals of the tables. NaN: undefined, e.g. the deviation of one value."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri, stdtrit  # scipy.stats gives the same and takes a second to load

NAN = float("nan")


class Interval(NamedTuple):
    """Ends of a confidence interval."""

    low: float
    high: float


def drop_missing(values: ArrayLike) -> NDArray[np.float64]:
    """The values that are there (None and NaN dropped), float64."""
    array = np.asarray(values, dtype=np.float64).ravel()
    return array[~np.isnan(array)]


def mean(values: ArrayLike) -> float:
    """Mean of the values that are there; NaN if there is none."""
    array = drop_missing(values)
    return float(array.mean()) if array.size else NAN


def std(values: ArrayLike) -> float:
    """Sample standard deviation (ddof = 1) of the values that are there; NaN below two values."""
    array = drop_missing(values)
    return float(array.std(ddof=1)) if array.size > 1 else NAN


def t_interval(values: ArrayLike, confidence: float) -> Interval:
    """Student's t interval of the mean.

    A scene has 5 to 15 objects: at that size it covers better than a percentile bootstrap, and it needs no seed.
    """
    array = drop_missing(values)
    if array.size < 2:
        return Interval(NAN, NAN)
    half = stdtrit(array.size - 1, (1 + confidence) / 2) * array.std(ddof=1) / np.sqrt(array.size)
    return Interval(float(array.mean() - half), float(array.mean() + half))


def wilson_of_rate(rate: float, trials: int, confidence: float) -> Interval:
    """Wilson score interval of a success rate over `trials`; `rate` may be a mean over repeated trials."""
    if trials == 0:
        return Interval(NAN, NAN)
    z2 = float(ndtri((1 + confidence) / 2)) ** 2
    middle = (rate + z2 / (2 * trials)) / (1 + z2 / trials)
    half = np.sqrt(z2 * (rate * (1 - rate) / trials + z2 / (4 * trials**2))) / (1 + z2 / trials)
    return Interval(0.0 if rate == 0 else float(middle - half), 1.0 if rate == 1 else float(middle + half))


def wilson(successes: int, episodes: int, confidence: float) -> Interval:
    """Wilson score interval of a success rate."""
    return wilson_of_rate(successes / episodes if episodes else 0.0, episodes, confidence)
