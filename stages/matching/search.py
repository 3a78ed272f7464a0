"""Nearest patches, exact and in one pass: T[q, c], the distance of query patch q to candidate picture c (paper A.6).

The paper searches all candidates' patches anew for every one of its top-k rounds. But a patch's nearest
neighbour over several pictures is the nearest of its nearest neighbours in each: with T at hand a round
is an arg-min over the columns that remain, and the embedding distance is a mean over a column.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.plugins import load

Rows = Callable[[int], NDArray[np.float32]]  # candidate picture -> its patches (P, D)
Backward = list[NDArray[np.float32]]
# search(query patches (Q, D), rows, C, both ways?): squared distance (Q, C) of each query patch to the nearest patch of
# each of C candidate pictures; and if both are asked, per picture that (P,) of each of its patches to the nearest of
# the query, else []
Search = Callable[[NDArray[np.float32], Rows, int, bool], tuple[NDArray[np.float32], Backward]]

TIE = 1e-5  # above the error of a squared distance in float32 (about 1e-6), relative to the squared lengths
DECIMALS = 9  # of a squared distance: its error in float64 is far below


class Nearest(NamedTuple):
    """L2 distances, both ways.

    table: T (Q, C), of every query patch to the nearest patch of every candidate picture. backward: per picture (P,),
    of each of its patches to the nearest query patch; [] if it was not asked for.
    """

    table: NDArray[np.float64]
    backward: list[NDArray[np.float64]]


def load_search(name: str) -> Search:
    """The search that the options name."""
    found: Search = load("searches", name)
    return found


def distance_table(
    queries: NDArray[np.float32], rows: Rows, count: int, search: str, nearest: int | None = None, both: bool = False
) -> Nearest:
    """Distances between the query's patches (Q, D) and those of `count` candidate pictures, from one product each.

    Float32 rounding differs between backends and could swap near ties. Entries among the `nearest` of a
    patch (default: all) that lie so close together are computed again in float64, and so is what is next
    to 0: all backends then make the same picks, equal pictures tie exactly, a picture has distance 0 to itself.
    """
    forward, backward = load_search(search)(queries, rows, count, both)
    table = np.maximum(forward.astype(np.float64), 0.0)
    tie = TIE * float((queries.astype(np.float64) ** 2).sum(1).max())
    doubtful = _find_doubtful(table, tie, nearest)
    for candidate in np.flatnonzero(doubtful.any(axis=0)).tolist():
        again = doubtful[:, candidate]
        table[again, candidate] = _float64_minimum(queries[again], rows(candidate))
    return Nearest(np.sqrt(table), [_lengths(way, tie, rows(number), queries) for number, way in enumerate(backward)])


def _lengths(
    squared: NDArray[np.float32], tie: float, patches: NDArray[np.float32], queries: NDArray[np.float32]
) -> NDArray[np.float64]:
    """Distances (P,) of patches to the query from their squares; those next to 0 are computed again in float64."""
    exact = np.maximum(squared.astype(np.float64), 0.0)
    again = exact <= tie
    if again.any():
        exact[again] = _float64_minimum(patches[again], queries)
    return np.sqrt(exact)


def _find_doubtful(table: NDArray[np.float64], tie: float, nearest: int | None) -> NDArray[np.bool_]:
    """Entries (Q, C) within `tie` of 0, or of the next larger or smaller one of the `nearest` in their row."""
    order = np.argsort(table, axis=1)[:, :nearest]
    close = np.diff(np.take_along_axis(table, order, axis=1), axis=1) <= tie
    near = np.zeros(order.shape, dtype=bool)
    near[:, 1:] |= close
    near[:, :-1] |= close
    doubtful = table <= tie
    np.put_along_axis(doubtful, order, np.take_along_axis(doubtful, order, axis=1) | near, axis=1)
    return doubtful


def _float64_minimum(queries: NDArray[np.float32], patches: NDArray[np.float32]) -> NDArray[np.float64]:
    """Smallest squared distance (Q,) of each query to the patches, to nine decimals."""
    query, patch = queries.astype(np.float64), patches.astype(np.float64)
    squared = (query**2).sum(1)[:, None] - 2 * query @ patch.T + (patch**2).sum(1)
    return np.maximum(np.round(squared.min(axis=1), DECIMALS), 0.0)
