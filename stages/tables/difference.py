"""Interval of the difference of two success rates that were measured from the same initial states."""

import numpy as np
from numpy.typing import NDArray

from stages.tables.statistics import Interval, wilson_of_rate

Successes = NDArray[np.float64]


def correlation(ours: Successes, baseline: Successes) -> float:
    """Correlation of the two sides over initial states, with Newcombe's continuity correction; 0 if it is undefined.

    For one run a side it is the phi coefficient of the paired 2 x 2 table.
    """
    x, y = ours.mean(axis=0), baseline.mean(axis=0)
    states = len(x)
    spread = float(np.sqrt(x.mean() * (1 - x.mean()) * y.mean() * (1 - y.mean()))) * states**2
    if spread == 0:
        return 0.0
    product = float((x * y).mean() - x.mean() * y.mean()) * states**2  # ad - bc of the table
    return (max(product - states / 2, 0.0) if product > 0 else product) / spread


def paired_interval(ours: Successes, baseline: Successes, confidence: float) -> Interval:
    """Newcombe's hybrid score interval of mean(ours) - mean(baseline) for paired proportions.

    R. G. Newcombe, "Improved confidence intervals for the difference between binomial proportions based on paired
    data", Statistics in Medicine 17 (1998) 2635-2650, method 10: the Wilson intervals of both sides are added in
    squares, with their correlation. It keeps its width at 0/n against 0/n, where a bootstrap has none.

    Args:
        ours, baseline: (runs, states) successes in {0, 1}; column s is the same initial state in both.
    """
    ends = [
        (float(side.mean()), *wilson_of_rate(float(side.mean()), side.size, confidence)) for side in (ours, baseline)
    ]
    (p, p_low, p_high), (q, q_low, q_high) = ends
    phi = correlation(ours, baseline)

    def added(a: float, b: float) -> float:
        return float(np.sqrt(max(a * a - 2 * phi * a * b + b * b, 0.0)))

    return Interval(p - q - added(p - p_low, q_high - q), p - q + added(p_high - p, q - q_low))


def bootstrap_interval(ours: Successes, baseline: Successes, confidence: float, samples: int, seed: int) -> Interval:
    """Bootstrap interval of mean(ours) - mean(baseline), over initial states, shared by both sides, and over runs."""
    rng = np.random.default_rng(seed)
    states = ours.shape[1]

    def weights(count: int) -> Successes:
        return rng.multinomial(count, np.full(count, 1 / count), size=samples) / count

    by_state = weights(states)
    rates = [np.einsum("br,rs,bs->b", weights(len(side)), side, by_state, optimize=True) for side in (ours, baseline)]
    low, high = np.quantile(rates[0] - rates[1], [(1 - confidence) / 2, (1 + confidence) / 2])
    return Interval(float(low), float(high))


def difference_interval(ours: Successes, baseline: Successes, confidence: float, samples: int, seed: int) -> Interval:
    """Interval of mean(ours) - mean(baseline), both (runs, states).

    With one run a side it is the paired score interval, and speaks of these trained policies, not of training again.
    With more it is the bootstrap over runs and states, but never narrower than the score interval of all episodes, so
    that runs which agree at 0 or 1 do not close it.
    """
    score = paired_interval(ours, baseline, confidence)
    if len(ours) == len(baseline) == 1:
        return score
    drawn = bootstrap_interval(ours, baseline, confidence, samples, seed)
    return Interval(min(score.low, drawn.low), max(score.high, drawn.high))
