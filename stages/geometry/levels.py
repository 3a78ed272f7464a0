"""Level surfaces of a picture with depth: floors, table tops, seats; and which of them is the floor."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry import room_planes

MIN_LEVEL = 0.05  # share of the largest level that another has at least: less is noise of a far floor; chosen
FEWEST = 8  # cells of a level
OFF_LEVEL = 0.006  # share of the distance by which points of a level may be off; chosen
LEVEL_FIT = np.cos(np.deg2rad(5))  # a plane fitted to a level is tilted by less, or it is none; chosen
ROUNDS = 5  # of the fit
TABLE_WITHIN = 2.0  # metres of the median depth: nearer is a table, farther a room; chosen
LARGE_LEVEL = 0.3  # share of the largest level that a table has at least: a lid has less; chosen
STEP = 0.02  # metres between heights at which a room's floor is sought; chosen
DEEPER = 0.08  # metres: what is farther below a floor is below it, not its noise; chosen
BELOW = 0.015  # share of the points that may lie below the floor: reflections, noise; chosen
Array = NDArray[np.float64]


def find_levels(points: Array, known: NDArray[np.bool_], up: Array) -> list[room_planes.Plane]:
    """Level surfaces that face up, the largest first: floors, table tops, seats; `inliers` over `points[known]`.

    All are parallel to the largest, to which a plane is fitted.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels that count.
        up: (3,) as of `find_up`.
    """
    centers, normals = room_planes.cell_normals(points, known)
    cells, cloud = centers[normals @ up > room_planes.LEVEL], points[known]
    off = OFF_LEVEL * float(np.median(cloud[:, 2])) if len(cells) else 0.0
    levels: list[room_planes.Plane] = []
    least: float = FEWEST
    while len(cells) >= least:
        heights = cells @ up
        order = np.sort(heights)
        counts = np.searchsorted(order, order + off) - np.searchsorted(order, order - off)
        if counts.max() < least:
            break
        height = float(order[counts.argmax()])
        if not levels:
            least = max(FEWEST, MIN_LEVEL * counts.max())
            up, height = _fit_level(cloud, up, height, off)
            heights = cells @ up
        along = cloud @ up
        height = float(np.median(along[np.abs(along - height) < off]))
        levels.append(room_planes.Plane(up, height, np.abs(along - height) < off))
        cells = cells[np.abs(heights - height) > 2 * off]
    return levels


def _fit_level(cloud: Array, up: Array, height: float, off: float) -> tuple[Array, float]:
    """Unit normal (3,) and offset of the plane through the points (N, 3) near a height along `up`."""
    some, normal, offset = room_planes.sample_points(cloud, np.random.default_rng(0)), up, height
    for _ in range(ROUNDS):
        near = some[np.abs(some @ normal - offset) < off]
        if len(near) < FEWEST:
            break
        fitted, at = room_planes.least_squares_plane(near)
        fitted, at = (fitted, at) if fitted @ up > 0 else (-fitted, -at)
        if fitted @ up < LEVEL_FIT:
            break
        normal, offset = fitted, at
    return normal, offset


def find_floor(
    points: Array, known: NDArray[np.bool_], free: NDArray[np.bool_], objects: Sequence[Array], up: Array
) -> room_planes.Plane | None:
    """The floor without a mask of it: the level (a table top, too) that most objects stand on.

    Of two with as many objects it is the one with fewer points below it. Args as of `find_levels`, and:

    Args:
        free: pixels (H, W) that belong to no object and no wall; the known ones count where none is.
        objects: (N, 3) of each object.
    """
    levels = find_levels(points, free, up) or find_levels(points, known, up)
    cloud = points[free if free.any() else known]
    limit = -room_planes.scale_threshold(cloud) if len(cloud) else 0.0

    def score(level: room_planes.Plane) -> tuple[int, float]:
        below = float((cloud @ level.normal - level.offset < limit).mean())
        return sum(stands_on(one, level) for one in objects), -below

    return max(levels, key=score, default=None)


def find_ground(points: Array, known: NDArray[np.bool_], max_tilt: float) -> room_planes.Plane | None:
    """The level surface on which things stand in a picture without labels: a near table top, else the room's floor.

    The floor is the height with most points of those below which hardly any lie: the little that is seen of it between
    furniture will do. Its `inliers` are over `points[known]`.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels with depth.
        max_tilt: largest angle between image-up and its normal, degrees.
    """
    up = room_planes.find_up(points, known, max_tilt)
    if up is None:
        return None
    cloud = points[known]
    if float(np.median(cloud[:, 2])) < TABLE_WITHIN:
        levels = find_levels(points, known, up)
        largest = max((level.inliers.sum() for level in levels), default=0)
        large = [level for level in levels if level.inliers.sum() >= LARGE_LEVEL * largest]
        return max(large, key=lambda level: level.offset, default=None)
    heights = cloud @ up
    edges = np.arange(heights.min(), STEP, STEP)
    if len(edges) < 4:
        return None  # nothing lies below the camera
    counts = np.convolve(np.histogram(heights, edges)[0], np.ones(3), "same")
    below = np.searchsorted(np.sort(heights), edges[:-1] - DEEPER) / len(heights)
    height = float(edges[np.argmax(counts * (below < BELOW))]) + STEP / 2
    near = np.abs(heights - height) < 1.5 * STEP
    return room_planes.Plane(up, float(np.median(heights[near])), near)


def stands_on(points: Array, level: room_planes.Plane) -> bool:
    """Whether the lowest of an object's points (N, 3), camera frame, are on a level."""
    reach = room_planes.PLANE_THRESHOLD * max(1.0, float(np.median(points[:, 2])))
    return bool(abs(np.quantile(points @ level.normal - level.offset, room_planes.STRAY)) < reach)
