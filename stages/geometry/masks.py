"""Masks of an image (H, W): where they lie, and those of polygons."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

FARTHEST = 30_000  # pixels: corners are drawn no farther out (OpenCV counts in 16 bits)


def pixel_bounds(mask: NDArray[np.bool_]) -> tuple[int, int, int, int]:
    """Bounds x0, y0, x1, y1 (exclusive) of a mask; all 0 if it is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return 0, 0, 0, 0
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def polygon(points: ArrayLike, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Pixels (H, W) inside a polygon of corners (N, 2), x and y; none if there are less than three."""
    mask = np.zeros(shape, dtype=np.uint8)
    corners = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    if len(corners) >= 3 and np.isfinite(corners).all():
        cv2.fillPoly(mask, [np.rint(np.clip(corners, -FARTHEST, FARTHEST)).astype(np.int32)], 1)
    return mask > 0
