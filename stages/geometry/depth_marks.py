"""Values of a depth image that are no distance: what a camera or a program writes where it knows none."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FEW = 20  # pixels: what fewer share may be a distance
VARIED = 100  # different other values: depth with fewer is drawn or made of planes
APART = 2.0  # times as far as everything else, or as near
OFTEN, SHARE = 20, 0.002  # times as many pixels as any value close by has, and of all pixels, that are cut off
CLOSE = 0.9  # share of the range from which on values are close by
NEAREST_CUT = 2.0  # metres: no camera's range is shorter


def marks_of(values: NDArray[Any]) -> list[float]:
    """Values (h, w) that mean `unknown`, besides what is not above 0: the type's largest, and what many pixels share
    exactly, at twice the distance of all others or more, or at half of it or less.
    """
    found, counts = _counted(values)
    marks: list[float] = []
    if len(found) > 1 and values.dtype.kind in "iu" and found[-1] == np.iinfo(values.dtype).max:
        marks, found, counts = [float(found[-1])], found[:-1], counts[:-1]
    while len(found) > VARIED:
        if counts[-1] >= FEW and found[-1] >= APART * found[-2]:
            marks, found, counts = [*marks, float(found[-1])], found[:-1], counts[:-1]
        elif counts[0] >= FEW and found[1] >= APART * found[0]:
            marks, found, counts = [*marks, float(found[0])], found[1:], counts[1:]
        else:
            break
    return marks


def range_of(metres: NDArray[np.floating]) -> float | None:
    """The distance at which depth (h, w) in metres is cut off: the largest, of whole half metres, and many times as
    common as any a little nearer. A wall that is exactly so far, and seen exactly straight on, is taken for it.
    """
    found, counts = _counted(metres)
    if len(found) <= VARIED:
        return None
    last, number = float(found[-1]), int(counts[-1])
    whole = last >= NEAREST_CUT and abs(2 * last - round(2 * last)) < 1e-4
    beside = int(counts[:-1][found[:-1] >= CLOSE * last].max(initial=1))
    many = number >= max(FEW, SHARE * metres.size, OFTEN * beside)
    return last if whole and many else None


def without(values: NDArray[Any], marks: list[float]) -> NDArray[Any]:
    """Values (h, w) with 0 in the place of marks."""
    return np.where(np.isin(values, np.asarray(marks, dtype=values.dtype)), 0, values) if marks else values


def _counted(values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    found, counts = np.unique(values[np.isfinite(values) & (values > 0)], return_counts=True)
    return found, counts
