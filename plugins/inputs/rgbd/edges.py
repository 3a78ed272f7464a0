"""Remove depth at object edges, where cameras mix an object with its background."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, correlate1d, distance_transform_edt, find_objects, minimum_filter

from stages.geometry.room_planes import STRAY

DEPTH_STEP = 0.02  # share of the distance, from pixel to pixel: less on a floor seen at 5 degrees by a usual camera
MIN_LEFT = 0.4  # share of an object that remains, else it is all edges and left alone; chosen
MIN_PART = 12  # pixels of the smallest thin part; chosen
SMEAR = 7  # pixels across, in which a smeared pixel has something nearer beside it; chosen
AROUND_PART = 11  # pixels across, in which the surroundings of a part are looked at; chosen


def find_smooth_pixels(depth: NDArray[np.float32], step: float) -> NDArray[np.bool_]:
    """Pixels (H, W) of known depth whose neighbours differ by less than `step`, a share of the distance."""
    known = depth > 0
    inverse = np.where(known, 1 / np.maximum(depth, 1e-6), 0)
    bends = [np.abs(correlate1d(inverse, [1, -2, 1], axis)) for axis in (0, 1)]  # 0 on planes
    slopes = [np.abs(correlate1d(inverse, [-0.5, 0, 0.5], axis)) for axis in (0, 1)]
    return np.asarray(known & (np.max([*bends, *slopes], axis=0) <= step * inverse))


def remove_edges(depth: NDArray[np.float32], masks: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Depth (H, W) that is unknown (0) where a mask (H, W) reaches beyond its thing, or depth changes by a step.

    At its edge a depth camera mixes a thing with what is behind it, and masks are some pixels off. Of what is too thin
    to have anything but edges (handles, spouts, poles) the nearest depth is kept: a mixed one is farther.
    """
    known, level = depth > 0, find_smooth_pixels(depth, DEPTH_STEP)
    front = known & (depth <= (1 + DEPTH_STEP) * minimum_filter(np.where(known, depth, np.inf), SMEAR))
    clean = depth.copy()
    for value, place in enumerate(find_objects(masks), 1):
        if place is None:
            continue
        near = tuple(slice(max(0, side.start - AROUND_PART), side.stop + AROUND_PART) for side in place)
        seen, whole = depth[near], masks[near] == value
        mask = whole & known[near]
        inner = binary_opening(mask & level[near], np.ones((3, 3)))
        parts, sizes = _parts(inner, 4)
        large = 1 + np.flatnonzero(sizes >= STRAY * inner.sum())
        if np.isin(parts, large).sum() <= MIN_LEFT * mask.sum():
            continue
        body = 1 + int(np.argmax(sizes))
        inner = np.isin(
            parts, [part for part in large if part == body or not _continues_outside(parts == part, whole, seen)]
        )
        kept = mask & (inner | _as_far_as(inner, seen))
        parts, sizes = _parts(mask & front[near], 8)  # no two neighbours of these are a step apart
        for part in 1 + np.flatnonzero(sizes >= MIN_PART):
            surface = parts == part
            if kept[surface].any() or not _continues_outside(surface, whole, seen):
                kept |= surface
        clean[near][mask & ~kept] = 0
    return clean


def _parts(mask: NDArray[np.bool_], connectivity: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Number of the connected part of each pixel (H, W), from 1 on, and the parts' sizes in pixels."""
    _, parts, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=connectivity)
    return np.asarray(parts, np.int32), np.asarray(stats[1:, cv2.CC_STAT_AREA], np.int32)


def _as_far_as(part: NDArray[np.bool_], depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Which pixels (H, W) are as far away as the nearest pixel of a part."""
    _, nearest = distance_transform_edt(~part, return_indices=True)
    return np.asarray(np.abs(depth - depth[tuple(nearest)]) <= DEPTH_STEP * depth)


def _continues_outside(part: NDArray[np.bool_], whole: NDArray[np.bool_], depth: NDArray[np.float32]) -> bool:
    """Whether a part goes on outside the mask `whole`: the background of an object whose mask is too wide."""
    around = cv2.dilate(part.astype(np.uint8), np.ones((AROUND_PART, AROUND_PART))) > 0
    outside = around & ~whole & (depth > 0)
    return bool(_as_far_as(part, depth)[outside].sum() > outside.sum() / 2)
