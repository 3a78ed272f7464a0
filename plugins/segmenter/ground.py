"""The level surface on which the things of a picture stand."""

import numpy as np
from numpy.typing import NDArray

from stages.geometry.gravity import cell_normals, estimate_up
from stages.geometry.levels import Array, find_levels
from stages.geometry.planes import Plane

TABLE_WITHIN = 2.0  # metres of the median depth: nearer is a table, farther a room; chosen
LARGE_LEVEL = 0.3  # share of the largest level that a table has at least: a lid has less; chosen


def find_ground(points: Array, known: NDArray[np.bool_], max_tilt: float) -> Plane | None:
    """The level surface on which things stand in a picture without labels: a near table top, else the floor.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels with depth.
        max_tilt: largest angle between image-up and its normal, degrees.
    """
    up = estimate_up(cell_normals(points, known)[1], max_tilt)
    if up is None:
        return None
    distance = float(np.median(points[known][:, 2]))
    levels = find_levels(points, known, up)
    if distance >= TABLE_WITHIN:
        return min(levels, key=lambda level: level.offset, default=None)
    largest = max((level.inliers.sum() for level in levels), default=0)
    large = [level for level in levels if level.inliers.sum() >= LARGE_LEVEL * largest]
    return max(large, key=lambda level: level.offset, default=None)
