"""Intervals of success rates and of their differences: assets, initial states and runs resampled, crossed.

A side is a table of successes: a row per policy, a column per place, that is an initial state on an asset of a family.
NaN: undefined, e.g. of one value.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from roomkin.stages.config.evaluation import TablesConfig

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


POLICY = ["run", "seed", "checkpoint"]
PLACE = ["family", "asset", "initial_state"]

Side = pd.DataFrame
Floats = NDArray[np.float64]


def side_of(rollouts: pd.DataFrame) -> Side:
    """Successes (policies, places) of some rows of `Rollout`; NaN where a policy was not tested."""
    return rollouts.pivot_table(index=POLICY, columns=PLACE, values="success", aggfunc="mean").astype(float)


def pair_sides(ours: Side, theirs: Side) -> tuple[Side, Side]:
    """Both sides at the places where all policies of both were tested."""
    places = ours.dropna(axis="columns").columns.intersection(theirs.dropna(axis="columns").columns)
    return ours[places], theirs[places]


def rate_of(side: Side) -> float:
    """Mean success: over runs, states of an asset, assets. NaN without places."""
    return float(side.mean().groupby(level=["family", "asset"]).mean().mean())


def unit_rates(side: Side) -> Floats:
    """Mean success of each unit of the score intervals: of every asset, or on a single asset from every state."""
    places = side.mean()
    assets = places.groupby(level=["family", "asset"]).mean()
    return np.asarray(assets if len(assets) > 1 else places, dtype=np.float64)


def place_weights(places: pd.Index, samples: int, rng: np.random.Generator) -> Floats:
    """Weights of the places in resamples of families and of states within assets.

    A single family is in every resample: the interval is about its assets alone. In the plain rate assets weigh alike.

    Returns:
        (samples, places), each row adds up to 1.
    """
    family, names = pd.factorize(places.get_level_values("family"))
    weights = rng.multinomial(len(names), np.full(len(names), 1 / len(names)), size=samples)[:, family].astype(float)
    asset, assets = pd.factorize(places.get_level_values("asset"))
    states = np.bincount(asset)
    state = pd.Series(asset).groupby(asset).cumcount().to_numpy()
    chances = (np.arange(states.max()) < states[:, None]) / states[:, None]
    times = rng.multinomial(states, chances, size=(samples, len(assets))) / states[:, None]
    weights *= times[:, asset, state]
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def resample_rates(groups: Sequence[Sequence[Side]], options: TablesConfig) -> list[list[Floats]]:
    """Bootstrap: the rates of every run, places and runs resampled.

    Args:
        groups: sides of one group share their places; the n-th sides of all groups are the same policies.

    Returns:
        By group and side (samples, runs) rates. A single run is in every resample: they speak of that policy alone.
    """
    samples, rng = options.bootstrap_samples, np.random.default_rng(options.seed)
    runs = [rng.integers(0, len(side), (samples, len(side))) for side in groups[0]]
    found = []
    for sides in groups:
        weights = place_weights(sides[0].columns, samples, rng)
        rates = [weights @ side.to_numpy().T for side in sides]
        found.append([np.take_along_axis(rate, picked, axis=1) for rate, picked in zip(rates, runs, strict=True)])
    return found


def quantiles(resamples: Floats, options: TablesConfig) -> Interval:
    """The percentile interval of a bootstrap."""
    tail = (1 - options.confidence) / 2
    low, high = np.quantile(resamples, [tail, 1 - tail])
    return Interval(float(low), float(high))


def join_intervals(one: Interval, other: Interval, least: float) -> Interval:
    """The interval that holds both, cut at `least` and 1."""
    return Interval(max(min(one.low, other.low), least), min(max(one.high, other.high), 1.0))


def rate_interval(side: Side, options: TablesConfig) -> Interval:
    """Interval of `rate_of`: the bootstrap, never narrower than Wilson's over the units (24 of 24 is no point).

    It is about the places where all policies were tested. If there are none, as for assets that every seed draws anew,
    it is Wilson's over the units of all.
    """
    if side.empty:
        return Interval(float("nan"), float("nan"))
    shared = side.dropna(axis="columns")
    units = side if shared.empty else shared
    score = wilson_of_rate(rate_of(units), len(unit_rates(units)), options.confidence)
    if shared.empty:
        return score
    ((rates,),) = resample_rates([[shared]], options)
    return join_intervals(quantiles(rates.mean(axis=1), options), score, 0.0)


def correlation(ours: Floats, theirs: Floats) -> float:
    """Correlation of the two sides over units, with Newcombe's continuity correction; 0 if it is undefined.

    For units of 0 and 1 it is the phi coefficient of the paired 2 x 2 table.
    """
    units = len(ours)
    p, q = ours.mean(), theirs.mean()
    spread = float(np.sqrt(max(p * (1 - p) * q * (1 - q), 0.0)))
    if spread < 1e-9:
        return 0.0
    product = float((ours * theirs).mean() - p * q)
    return (max(product - 1 / (2 * units), 0.0) if product > 0 else product) / spread


def score_interval(ours: Floats, theirs: Floats, confidence: float) -> Interval:
    """Newcombe's hybrid score interval of mean(ours) - mean(theirs) for paired proportions.

    R. G. Newcombe, "Improved confidence intervals for the difference between binomial proportions based on paired
    data", Statistics in Medicine 17 (1998) 2635-2650, method 10: the Wilson intervals of both sides are added in
    squares, with their correlation. It keeps its width at 0/n against 0/n, where a bootstrap has none.

    Args:
        ours, theirs: (units,) rates in [0, 1]; rates between 0 and 1 make it wider than it need be.
    """
    p, q = float(ours.mean()), float(theirs.mean())
    (p_low, p_high), (q_low, q_high) = (wilson_of_rate(rate, len(ours), confidence) for rate in (p, q))
    phi = correlation(ours, theirs)

    def add_in_quadrature(a: float, b: float) -> float:
        return float(np.sqrt(max(a * a - 2 * phi * a * b + b * b, 0.0)))

    return Interval(p - q - add_in_quadrature(p - p_low, q_high - q), p - q + add_in_quadrature(p_high - p, q - q_low))


def difference_interval(ours: Side, theirs: Side, options: TablesConfig, same: bool = False) -> Interval:
    """Interval of rate_of(ours) - rate_of(theirs), sides at the same places.

    It is the bootstrap, never narrower than the score interval over the units.

    Args:
        same: the rows of both sides are the same policies, resampled together; else each side has its own.
    """
    if same:
        ((rates,),) = resample_rates([[ours - theirs]], options)
        found = rates.mean(axis=1)
    else:
        ((a, b),) = resample_rates([[ours, theirs]], options)
        found = a.mean(axis=1) - b.mean(axis=1)
    score = score_interval(unit_rates(ours), unit_rates(theirs), options.confidence)
    return join_intervals(quantiles(found, options), score, -1.0)
