"""Intervals of the tables. NaN: undefined, e.g. of one value."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import ndtri, stdtrit  # scipy.stats gives the same and takes a second to load

NAN = float("nan")


class Interval(NamedTuple):
    """Ends of a confidence interval."""

    low: float
    high: float


def t_interval(values: pd.Series, confidence: float) -> Interval:
    """Student's t interval of the mean.

    A scene has 5 to 15 objects: at that size it covers better than a percentile bootstrap, and it needs no seed.
    """
    known = values.dropna()
    if len(known) < 2:
        return Interval(NAN, NAN)
    half = float(stdtrit(len(known) - 1, (1 + confidence) / 2) * known.sem())
    return Interval(known.mean() - half, known.mean() + half)


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
