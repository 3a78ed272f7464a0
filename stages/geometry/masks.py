"""Masks of an image (H, W): bounds, polygons, and the pixels that can be trusted (paper A.7)."""

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Mask = NDArray[np.bool_]
FARTHEST_CORNER = 30_000  # pixels: corners are drawn no farther out (OpenCV counts in 16 bits)
OUTLINE = 3  # pixels by which the outline of a mask may be off; chosen
EROSION = 2  # pixels taken off the border of masks before clouds are made; A.7 gives no number; chosen
SPECK = 0.01  # parts of a mask with a smaller share of its pixels are specks; chosen
CORNERS = 1000  # of an outline, as `roomkin.stages.contracts.types.Outline`
PIECES = 50  # of an outline beside its first
MIN_PIXELS = 60  # of a mask: fewer show neither a shape nor a surface; chosen


def pixel_bounds(mask: Mask) -> tuple[int, int, int, int]:
    """Bounds x0, y0, x1, y1 (exclusive) of a mask; all 0 if it is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return 0, 0, 0, 0
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def polygon(points: ArrayLike, shape: tuple[int, int]) -> Mask:
    """Pixels (H, W) inside a polygon of corners (N, 2), x and y; none if there are less than three."""
    mask = np.zeros(shape, dtype=np.uint8)
    corners = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    if len(corners) >= 3 and np.isfinite(corners).all():
        cv2.fillPoly(mask, [np.rint(np.clip(corners, -FARTHEST_CORNER, FARTHEST_CORNER)).astype(np.int32)], 1)
    return mask > 0


def polygons(outlines: Iterable[ArrayLike], shape: tuple[int, int]) -> Mask:
    """Pixels (H, W) inside any of some polygons."""
    inside = np.zeros(shape, dtype=bool)
    for points in outlines:
        inside |= polygon(points, shape)
    return inside


def central_crop(shape: tuple[int, int], share: float) -> Mask:
    """Mask (H, W) of the central `share` of the image in either direction."""
    inside = np.zeros(shape, dtype=bool)
    v, u = (round(length * (1 - share) / 2) for length in shape)
    inside[v : shape[0] - v, u : shape[1] - u] = True
    return inside


def remove_specks(mask: Mask) -> Mask:
    """The mask without its tiny separate parts."""
    _, parts, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] >= SPECK * mask.sum()
    large[0] = False
    return large[parts]


def outline_mask(mask: Mask) -> list[list[list[int]]]:
    """Outlines of a mask as lists of pixels x, y, a pixel off at most, the largest first, without specks."""
    curves, _ = cv2.findContours(remove_specks(mask).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    largest = sorted(curves, key=cv2.contourArea, reverse=True)
    return [cv2.approxPolyDP(curve, 1.0, True)[:, 0].tolist() for curve in largest]


def erode(mask: Mask, keep: float = 0.25) -> Mask:
    """Take `EROSION` pixels off the border, fewer if less than a share of `keep` of the mask would remain."""
    for size in range(EROSION, 0, -1):
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * size + 1, 2 * size + 1))
        smaller = cv2.erode(mask.astype(np.uint8), kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
        if smaller.sum() >= keep * mask.sum():
            return smaller
    return mask


def lowest_pixels(own: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns (N,) and rows (N,) of the lowest pixel of a mask (H, W) in each column."""
    columns = np.flatnonzero(own.any(axis=0))
    return columns, own.shape[0] - 1 - np.argmax(own[::-1, columns], axis=0)


def outline_pieces(mask: Mask) -> list[list[list[int]]]:
    """Outlines of a mask's pieces, the largest first."""
    rings = [points[:: 1 + (len(points) - 1) // CORNERS] for points in outline_mask(mask)]
    return [points for points in rings if len(points) > 2][: PIECES + 1]


def look_below(
    masks: NDArray[np.integer],
    value: int,
    steps: Iterable[int],
    heights: NDArray[np.float64] | None = None,
    apart: float = np.inf,
) -> int:
    """What masks (H, W) show below most of the lower edge of one of them: the value of another; 0: not one thing.

    Args:
        steps: pixels below it at which is looked, the nearest first.
        heights: (H, W) metres, NaN: unknown; what is `apart` metres higher or lower does not count.
    """
    columns, rows = lowest_pixels(masks == value)
    below = np.zeros(len(columns), dtype=masks.dtype)
    for step in steps:
        at = np.minimum(rows + step, len(masks) - 1)
        met = np.where(masks[at, columns] == value, 0, masks[at, columns])
        if heights is not None:
            met = np.where(np.abs(heights[at, columns] - heights[rows, columns]) < apart, met, 0)
        below = np.where(below == 0, met, below)
    counts = np.bincount(below, minlength=1)
    counts[0] = 0
    return int(counts.argmax()) if 2 * counts.max() >= len(columns) else 0
