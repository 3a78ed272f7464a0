"""Depth at the edges of things, which is neither theirs nor that of what is behind them."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, correlate1d, distance_transform_edt

STEP = 0.02  # share of the distance, from pixel to pixel: less on a floor seen at 5 degrees by a usual camera
LEAST, PART = 0.4, 0.02  # of a thing that remains, else it is all edges and left alone; of it, for its smallest part


def without_edges(depth: NDArray[np.float32], masks: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Depth (H, W) that is unknown (0) where a mask (H, W) reaches beyond its thing, or depth changes by a step.

    At its edge a depth camera mixes a thing with what is behind it, and masks are some pixels off.
    """
    known = depth > 0
    inverse = np.where(known, 1 / np.maximum(depth, 1e-6), 0)
    bends = [np.abs(correlate1d(inverse, [1, -2, 1], axis)) for axis in (0, 1)]  # 0 on planes
    slopes = [np.abs(correlate1d(inverse, [-0.5, 0, 0.5], axis)) for axis in (0, 1)]
    level = known & (np.max([*bends, *slopes], axis=0) <= STEP * inverse)
    clean = depth.copy()
    for value in np.unique(masks[masks > 0]):
        mask = (masks == value) & known
        inner = binary_opening(mask & level, np.ones((3, 3)))
        _, parts, stats, _ = cv2.connectedComponentsWithStats(inner.astype(np.uint8), connectivity=4)
        large = 1 + np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= PART * inner.sum())
        inner = np.isin(parts, large)
        if inner.sum() < LEAST * mask.sum():
            continue
        _, nearest = distance_transform_edt(~inner, return_indices=True)
        thin = np.abs(depth - depth[tuple(nearest)]) <= STEP * depth  # a handle, as far away as what it belongs to
        clean[mask & ~inner & ~thin] = 0
    return clean
