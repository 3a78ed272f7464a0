"""Join pixels into things by average linkage, in rounds: regions that are each other's best neighbour become one.

A region's link to the union of two others is the mean of its links to them, never above the better one, so that rounds
of mutual bests come to what joining the best pair first comes to (reducibility: Bruynooghe 1977).
"""

import numpy as np
from numpy.typing import NDArray

from plugins.segmenter.network import NEIGHBOURS

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

VOTES = 1.0  # what votes for the same centre add to the log-odds that two pixels are of one thing; chosen
MOST = 6.0  # of the log-odds of a pair, either way: no pair alone decides
JOINED = -1.0  # mean log-odds above which regions are joined; chosen


def join_pixels(free: NDArray[np.bool_], same: Array, votes: Array, radius: Array, least: float = JOINED) -> Labels:
    """Region (H, W) of every pixel, from 0 on, -1: not `free`.

    Args:
        free: (H, W) pixels of things.
        same: (k * len(NEIGHBOURS), H, W) log-odds that the pixel is of the same thing as its neighbour; then as those
            twice as far, and so on.
        votes: (H, W, 3) where it says its thing's centre is, metres; NaN: its depth is unknown.
        radius: (H, W) of its thing's box, metres.
        least: mean log-odds of a link from which two regions are joined.
    """
    number = np.full(free.shape, -1)
    number[free] = np.arange(free.sum())
    firsts, seconds, scores = [], [], []
    for channel, log_odds in enumerate(same):
        rows, columns = (2 ** (channel // len(NEIGHBOURS)) * step for step in NEIGHBOURS[channel % len(NEIGHBOURS)])
        one, other = _pair(number, rows, columns)
        kept = (one >= 0) & (other >= 0)
        here, there = _pair(votes, rows, columns)
        gap = np.linalg.norm(here - there, axis=-1) / np.minimum(*_pair(radius, rows, columns))
        agree = np.nan_to_num(VOTES * (1 - 2 * gap).clip(-2.0))
        score = _pair(log_odds, rows, columns)[0].clip(-MOST, MOST) + agree
        firsts.append(one[kept])
        seconds.append(other[kept])
        scores.append(score[kept])
    first, second, score = (np.concatenate(each) for each in (firsts, seconds, scores))
    regions = link_averages(int(free.sum()), first, second, score, least)
    number[free] = regions
    return number


def _pair(values: NDArray, rows: int, columns: int) -> tuple[NDArray, NDArray]:  # type: ignore[type-arg]
    """Values (H, W, ...) at pixels and at those so many rows below and columns beside them, where both are inside."""
    height, width = values.shape[:2]
    left, right = max(0, -columns), min(width, width - columns)
    return values[: max(0, height - rows), left:right], values[rows:, left + columns : max(0, right + columns)]


def link_averages(count: int, first: Labels, second: Labels, score: Array, least: float) -> Labels:
    """Region (count,) of every node, from 0 on: average linkage over the links (E,), down to a mean of `least`."""
    region = np.arange(count)
    total, weight = score.astype(float), np.ones(len(score))
    while len(total):
        mean = total / weight
        order = np.argsort(mean, kind="stable")
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order))
        best = np.full(count, -1)
        np.maximum.at(best, first, rank)
        np.maximum.at(best, second, rank)
        joined = (best[first] == rank) & (best[second] == rank) & (mean > least)
        if not joined.any():
            break
        parent = np.arange(count)
        parent[second[joined]] = first[joined]
        region = parent[region]
        first, second, total, weight = _contract(parent[first], parent[second], total, weight, count)
    return np.unique(region, return_inverse=True)[1].reshape(-1)


def _contract(
    first: Labels, second: Labels, total: Array, weight: Array, count: int
) -> tuple[Labels, Labels, Array, Array]:
    """The links between different nodes, those between the same two as one."""
    apart = first != second
    low, high = np.minimum(first, second)[apart], np.maximum(first, second)[apart]
    key, which = np.unique(low * count + high, return_inverse=True)
    return (
        key // count,
        key % count,
        np.bincount(which, total[apart], len(key)).astype(float),
        np.bincount(which, weight[apart], len(key)).astype(float),
    )
