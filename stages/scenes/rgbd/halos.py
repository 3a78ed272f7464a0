"""Halos: pixels beside a thing to which a depth camera gives a depth between the thing's and the table's.

They show the table, and have its colours, not those of the thing.
"""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_fill_holes, binary_opening, gaussian_filter

BINS, BLUR = 16, 0.7  # of each of L, a, b; in bins
RING = 61  # pixels around a thing, in which the table is looked at
LIKELIER = 2.0  # times that a colour must be the table's rather than the thing's
LEAST, PART = 0.4, 0.1  # of a thing that remains, else it is of the table's colours; of its largest piece, for others


def without_halos(values: NDArray[np.uint16], rgb: NDArray[np.uint8], table: NDArray[np.bool_]) -> NDArray[np.uint16]:
    """Masks (H, W) without what looks like the table around them, where `table` is known to be seen."""
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB).astype(int) * BINS // 256
    colour = np.ravel_multi_index(tuple(np.moveaxis(lab, -1, 0)), (BINS, BINS, BINS))
    kept = values.copy()
    for value in np.unique(values[values > 0]):
        mask = values == value
        around = cv2.dilate(mask.astype(np.uint8), np.ones((RING, RING), np.uint8)) > 0
        around &= table & (values == 0)
        if not around.any():
            continue
        strange = (_shares(colour[around]) > LIKELIER * _shares(colour[mask]))[colour] & mask
        own = mask & (cv2.medianBlur(strange.astype(np.uint8), 7) == 0)
        _, pieces, stats, _ = cv2.connectedComponentsWithStats(binary_opening(own, np.ones((3, 3))).astype(np.uint8))
        sizes = stats[1:, cv2.CC_STAT_AREA]
        large = 1 + np.flatnonzero(sizes >= PART * sizes.max(initial=0))
        own = mask & binary_fill_holes(binary_closing(np.isin(pieces, large), np.ones((7, 7))))
        if own.sum() >= LEAST * mask.sum():
            kept[mask & ~own] = 0
    return kept


def _shares(colours: NDArray[np.int64]) -> NDArray[np.float64]:
    """Share of each colour among those of some pixels, smoothed."""
    counts = np.bincount(colours, minlength=BINS**3).reshape(BINS, BINS, BINS).astype(float)
    return np.asarray(gaussian_filter(counts, BLUR)).ravel() / len(colours)
