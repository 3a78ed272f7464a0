"""What masks show, against depth: a value that lies in two places, and a thing that is shaped as a floor or wall is."""

from dataclasses import replace
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, correlate1d, distance_transform_edt, find_objects, minimum_filter
from scipy.sparse.csgraph import connected_components

from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.geometry.frames import PointMap
from roomkin.stages.geometry.room_planes import STRAY, fit_plane, scale_threshold
from roomkin.stages.perception.read.frame import Frame, surface_of

# Chosen.
LARGE_SHARE, LARGE_PIXELS = 0.1, 40  # of the largest piece, and pixels: what is smaller belongs to the nearest piece
GAP = 0.25  # times the smaller piece: nearer pieces are one thing
NEARER = 0.02  # share of the distance by which something is before a thing
BESIDE = 0.15  # likewise, by which another thing between two pieces is as far as they are
END = 3  # pixels around a piece's end in which its depth is looked at
FLAT, SEEN = 0.9, 0.03  # shares of a thing's points, and of the picture's pixels
ITERATIONS = 200  # of RANSAC, where most points are on the plane or it is none

Mask = NDArray[np.bool_]
DEPTH_STEP = 0.02  # share of the distance, from pixel to pixel: less on a floor seen at 5 degrees by a usual camera
MIN_LEFT = 0.4  # share of an object that remains, else it is all edges and left alone; chosen
MIN_PART = 12  # pixels of the smallest thin part; chosen
SMEAR = 7  # pixels across, in which a smeared pixel has something nearer beside it; chosen
AROUND_PART = 11  # pixels across, in which the surroundings of a part are looked at; chosen


def split_values(frame: Frame) -> Frame:
    """The frame with a value of its own for each thing that shared one, as in maps of classes. Each is printed.

    Pieces of one value are one thing where they are near each other, or something may hide what lies between them,
    which is doubted if it is larger than they are. So it is where masks tell things of one name apart: nothing is split
    there, for a thing's outline may lack thin parts.
    """
    assert frame.masks is not None
    values, labels, doubts = frame.masks.values.copy(), dict(frame.masks.labels), dict(frame.masks.doubts)
    seen = PointMap(frame.depth, frame.intrinsics)
    named = {value: label for value, label in labels.items() if not surface_of(label)}
    things, told_apart = np.isin(values, [*named]), len(set(named.values())) < len(named)
    for value, label in named.items():
        found, apart = _find_things(values, value, things, seen, told_apart)
        if apart:
            doubts[value] = [*doubts.get(value, []), DoubtKind.APART.of(distance=100 * apart)]
        if len(found) > 1:
            what = "one thing, for masks tell things of one name apart" if told_apart else "as many things"
            print(f"{label!r} (value {value}) lies in {len(found)} places: taken for {what}")
        for mask in [] if told_apart else found[1:]:
            number = max(labels) + 1
            values[mask], labels[number] = number, label
    return replace(frame, masks=replace(frame.masks, values=values, labels=labels, doubts=doubts))


def _find_things(
    values: NDArray[np.uint16], value: int, things: Mask, seen: PointMap, told_apart: bool
) -> tuple[list[Mask], float]:
    """The pixels (H, W) of each thing of a value, and the metres between pieces that may be one, or 0.

    Args:
        told_apart: any pieces may be one.
    """
    parts, sizes = _parts(values == value, 8)
    large = 1 + np.flatnonzero(sizes >= max(LARGE_PIXELS, LARGE_SHARE * sizes.max(initial=0)))
    pieces = [mask for part in large if (mask := (parts == part) & seen.known).any()]
    if len(pieces) < 2:
        return [values == value], 0.0
    ranges = [np.percentile(seen.of(piece), (5, 95), axis=0) for piece in pieces]
    extents = [float(np.linalg.norm(high - low)) for low, high in ranges]
    one, apart = np.eye(len(pieces), dtype=bool), 0.0
    for k, other in combinations(range(len(pieces)), 2):
        gap, hides = _look_between(pieces[k], pieces[other], things & (values != value), seen)
        one[k, other] = gap <= GAP * min(extents[k], extents[other]) or hides
        if (hides or told_apart) and gap > max(extents[k], extents[other]):
            apart = max(apart, gap)
    number, group = connected_components(one, directed=False)
    nearest = distance_transform_edt(~np.any(pieces, axis=0), return_distances=False, return_indices=True)
    owner = np.sum([(1 + group[k]) * piece for k, piece in enumerate(pieces)], axis=0)[tuple(nearest)]
    return [(values == value) & (owner == 1 + k) for k in range(number)], apart


def _look_between(piece: Mask, other: Mask, things: Mask, seen: PointMap) -> tuple[float, bool]:
    """Metres between two pieces (H, W), and whether what lies on the line between their nearest pixels may hide a part
    of their thing."""
    away, nearest = distance_transform_edt(~piece, return_indices=True)
    rows, columns = np.nonzero(other)
    k = int(away[rows, columns].argmin())
    ends = [nearest[:, rows[k], columns[k]], np.array([rows[k], columns[k]])]
    points = [_end_of(mask, end, seen) for mask, end in zip((piece, other), ends, strict=True)]
    gap = float(np.linalg.norm(points[1] - points[0]))
    steps = np.linspace(0, 1, 2 + int(np.abs(ends[1] - ends[0]).max()))[1:-1]
    line = tuple(np.rint(ends[0] + steps[:, None] * (ends[1] - ends[0])).astype(int).T)
    expected, found = points[0][2] + steps * (points[1][2] - points[0][2]), seen.depth[line]
    thing = things[line] & (np.abs(found / expected - 1) < BESIDE)
    known = found > 0
    hides = ((found < (1 - NEARER) * expected) | thing)[known]
    return gap, bool(hides.size and hides.mean() >= 0.5)


def _end_of(piece: Mask, end: NDArray[np.intp], seen: PointMap) -> NDArray[np.float64]:
    """The median point (3,) of a piece (H, W) around one of its pixels."""
    around = tuple(slice(max(0, one - END), one + END + 1) for one in end)
    return np.asarray(np.median(seen.points[around][piece[around]], axis=0))


def doubt_surfaces(frame: Frame) -> Frame:
    """The frame in which things are doubted that are flat and behind which nothing lies, as of floors and walls. What
    lies in the plane of a named floor or wall is a rug, a picture or a door."""
    assert frame.masks is not None
    masks, seen = frame.masks, PointMap(frame.depth, frame.intrinsics)
    points, rng = seen.points[seen.known], np.random.default_rng(0)
    surfaces = [value for value, label in masks.labels.items() if surface_of(label) in ("floor", "wall")]
    named = [seen.of(masks.values == value) for value in surfaces]
    doubts = dict(masks.doubts)
    for value, label in masks.labels.items():
        own = seen.of(masks.values == value)
        if surface_of(label) or len(own) < SEEN * masks.values.size:
            continue
        off = scale_threshold(own)
        plane = fit_plane(own, off, ITERATIONS, rng)
        if plane is None or plane.inliers.mean() < FLAT:
            continue
        side = np.sign(plane.offset)  # the camera, the origin, is on the other
        behind = (side * (points @ plane.normal - plane.offset) > 2 * off).mean()
        on_named = any((np.abs(one @ plane.normal - plane.offset) < 2 * off).mean() > 0.5 for one in named if len(one))
        if behind < STRAY and not on_named:
            print(f"{label!r} (value {value}) is flat, and nothing lies behind it: call it floor or wall if it is one")
            doubts[value] = [*doubts.get(value, []), DoubtKind.SURFACE.of()]
    return replace(frame, masks=replace(masks, doubts=doubts))


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
        own = [part for part in large if part == body or not _continues_outside(parts == part, whole, seen)]
        inner = np.isin(parts, own)
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
