"""Values of a depth image that stand for unknown depth, not for a distance."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

# Chosen; what they find on frames of cameras is in docs/results/your-data.md.
MIN_PIXELS = 20  # that share a value; one of fewer may be a distance
MIN_VALUES = 100  # different other values; depth with fewer is drawn or made of planes
SET_APART = 2.0  # times as far as everything else, or as near


def find_marks(values: NDArray[Any]) -> list[float]:
    """Values above 0 that mean `unknown` in depth (h, w): the largest of the type, and one that many pixels share, at
    least twice as far as all others or at most half as far.
    """
    found, counts = count_values(values)
    marks: list[float] = []
    if len(found) > 1 and values.dtype.kind in "iu" and found[-1] == np.iinfo(values.dtype).max:
        marks, found, counts = [float(found[-1])], found[:-1], counts[:-1]
    while len(found) > MIN_VALUES:
        if counts[-1] >= MIN_PIXELS and found[-1] >= SET_APART * found[-2]:
            marks, found, counts = [*marks, float(found[-1])], found[:-1], counts[:-1]
        elif counts[0] >= MIN_PIXELS and found[1] >= SET_APART * found[0]:
            marks, found, counts = [*marks, float(found[0])], found[1:], counts[1:]
        else:
            break
    return marks


def remove_marks(values: NDArray[Any], marks: list[float]) -> NDArray[Any]:
    """The values (h, w), with 0 in place of the marks."""
    return np.where(np.isin(values, np.asarray(marks, dtype=values.dtype)), 0, values) if marks else values


def count_values(values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """The known values above 0 of depth (h, w) in ascending order, and how many pixels have each."""
    found, counts = np.unique(values[np.isfinite(values) & (values > 0)], return_counts=True)
    return found, counts
