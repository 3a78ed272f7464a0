"""Values of a depth image that stand for unknown depth, not for a distance."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

# Chosen; what they find on frames of cameras is in docs/results/your-data.md.
MIN_PIXELS = 20  # that share a value; one of fewer may be a distance
MIN_VALUES = 100  # different other values; depth with fewer is drawn or made of planes
SET_APART = 2.0  # times as far as everything else, or as near
CUT_TIMES, CUT_SHARE = 20, 0.002  # times the pixels of any nearby value, and share of all, at the end of the range
NEARBY = 0.9  # share of the range from which on values are nearby
MIN_RANGE = 2.0  # metres: no camera's range is shorter


def find_marks(values: NDArray[Any]) -> list[float]:
    """Values above 0 that mean `unknown` in depth (h, w): the largest of the type, and one that many pixels share, at
    least twice as far as all others or at most half as far.
    """
    found, counts = _count_values(values)
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


def find_cut_range(metres: NDArray[np.floating]) -> float | None:
    """The distance at which depth (h, w) in metres is cut off: the largest, of whole half metres, and many times as
    common as any a little nearer. A wall at exactly that distance, seen straight on, is mistaken for the cut.
    """
    found, counts = _count_values(metres)
    if len(found) <= MIN_VALUES:
        return None
    last, number = float(found[-1]), int(counts[-1])
    whole = last >= MIN_RANGE and abs(2 * last - round(2 * last)) < 1e-4
    nearby = int(counts[:-1][found[:-1] >= NEARBY * last].max(initial=1))
    many = number >= max(MIN_PIXELS, CUT_SHARE * metres.size, CUT_TIMES * nearby)
    return last if whole and many else None


def remove_marks(values: NDArray[Any], marks: list[float]) -> NDArray[Any]:
    """The values (h, w), with 0 in place of the marks."""
    return np.where(np.isin(values, np.asarray(marks, dtype=values.dtype)), 0, values) if marks else values


def _count_values(values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    found, counts = np.unique(values[np.isfinite(values) & (values > 0)], return_counts=True)
    return found, counts
