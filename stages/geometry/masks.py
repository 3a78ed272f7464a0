"""Masks of an image (H, W): where they lie."""

import numpy as np
from numpy.typing import NDArray


def pixel_bounds(mask: NDArray[np.bool_]) -> tuple[int, int, int, int]:
    """Bounds x0, y0, x1, y1 (exclusive) of a mask; all 0 if it is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return 0, 0, 0, 0
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1
