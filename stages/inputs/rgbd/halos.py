"""Pixels near a thing whose depth is wrong, told by colour: halos, which are the table's, and what is as flat as it.

Beside things a depth camera gives a depth between the thing's and the table's; the inside and the lower edge of white
or shiny things it gives the table's.
"""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_fill_holes, binary_opening, gaussian_filter

BINS, BLUR = 16, 0.7  # of each of L, a, b; in bins
RING = 61  # pixels around a thing, in which the table is looked at
PASSES = 2  # at the first the halo's colours are among the thing's
LIKELIER = 2.0  # times that a colour must be the table's rather than the thing's
OWN = 4.0  # times that it must be the thing's: shadows are a little alike
MOST = 3.0  # times of a thing that may be added
LEAST, PART = 0.4, 0.1  # of a thing that remains, else it is of the table's colours; of its largest piece, for others


def without_halos(values: NDArray[np.uint16], rgb: NDArray[np.uint8], table: NDArray[np.bool_]) -> NDArray[np.uint16]:
    """Masks (H, W) without what looks like the table around them, where `table` is known to be seen."""
    colour, kept = _colours(rgb), values.copy()
    for value in np.unique(values[values > 0]):
        mask = values == value
        around = _around(mask) & table & (values == 0)
        if not around.any():
            continue
        own = mask
        for _ in range(PASSES):
            own = _own(own, colour, _shares(colour[around]))
        if own.sum() >= LEAST * mask.sum():
            kept[mask & ~own] = 0
    return kept


def _own(mask: NDArray[np.bool_], colour: NDArray[np.int64], table: NDArray[np.float64]) -> NDArray[np.bool_]:
    """The large parts of a mask that have not the table's colours, of which it tells the shares."""
    if not mask.any():
        return mask
    strange = (table > LIKELIER * _shares(colour[mask]))[colour] & mask
    own = mask & (cv2.medianBlur(strange.astype(np.uint8), 7) == 0)
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(binary_opening(own, np.ones((3, 3))).astype(np.uint8))
    sizes = stats[1:, cv2.CC_STAT_AREA]
    large = 1 + np.flatnonzero(sizes >= PART * sizes.max(initial=0))
    return np.asarray(mask & binary_fill_holes(binary_closing(np.isin(pieces, large), np.ones((7, 7)))))


def completed(values: NDArray[np.uint16], rgb: NDArray[np.uint8], table: NDArray[np.bool_]) -> NDArray[np.uint16]:
    """Masks (H, W) with what adjoins them and has their colours, though depth says `table`."""
    colour, whole = _colours(rgb), values.copy()
    for value in np.unique(values[values > 0]):
        mask = values == value
        around = _around(mask)
        beside = around & table & (values == 0)
        if not beside.any():
            continue
        free = around & table & (whole == 0)
        alike = free & (_shares(colour[mask]) > OWN * _shares(colour[beside]))[colour] | mask
        alike &= (cv2.medianBlur(alike.astype(np.uint8), 5) > 0) | mask
        _, pieces = cv2.connectedComponents(alike.astype(np.uint8), connectivity=4)
        own = np.isin(pieces, np.unique(pieces[mask]))
        added = binary_fill_holes(binary_closing(own, np.ones((3, 3)))) & free
        if own.sum() > mask.sum() >= added.sum() / MOST:
            whole[added] = value
    return whole


def _colours(rgb: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Number of each pixel's colour."""
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB).astype(int) * BINS // 256
    return np.asarray(np.ravel_multi_index(tuple(np.moveaxis(lab, -1, 0)), (BINS, BINS, BINS)))


def _around(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((RING, RING), np.uint8)) > 0)


def _shares(colours: NDArray[np.int64]) -> NDArray[np.float64]:
    """Share of each colour among those of some pixels, smoothed."""
    counts = np.bincount(colours, minlength=BINS**3).reshape(BINS, BINS, BINS).astype(float)
    return np.asarray(gaussian_filter(counts, BLUR)).ravel() / len(colours)
