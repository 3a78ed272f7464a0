"""The range of a depth camera, where depth is cut off at it."""

import numpy as np
from numpy.typing import NDArray

from stages.geometry.depth_marks import MIN_PIXELS, MIN_VALUES, count_values

# Chosen; what they find on frames of cameras is in docs/results/your-data.md.
CUT_TIMES, CUT_SHARE = 20, 0.002  # times the pixels of any nearby value, and share of all, at the end of the range
NEARBY = 0.9  # share of the range from which on values are nearby
MIN_RANGE = 2.0  # metres: no camera's range is shorter


def find_cut_range(metres: NDArray[np.floating]) -> float | None:
    """The distance at which depth (h, w) in metres is cut off: the largest, of whole half metres, and many times as
    common as any a little nearer. A wall at exactly that distance, seen straight on, is mistaken for the cut.
    """
    found, counts = count_values(metres)
    if len(found) <= MIN_VALUES:
        return None
    last, number = float(found[-1]), int(counts[-1])
    whole = last >= MIN_RANGE and abs(2 * last - round(2 * last)) < 1e-4
    nearby = int(counts[:-1][found[:-1] >= NEARBY * last].max(initial=1))
    many = number >= max(MIN_PIXELS, CUT_SHARE * metres.size, CUT_TIMES * nearby)
    return last if whole and many else None
