"""Remove depth of reflections: what a mirror or a pane shows seems to lie behind the wall that it hangs on."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from stages.contracts.objects import DepthError, Wall
from stages.geometry.estimate import REACH

AT_WALL = 0.2  # share of a thing's points before a wall's plane, from which on it is in this room
BEHIND = 0.3  # metres behind the plane, besides the error of depth: more than a niche is deep


def without_reflections(
    depth: NDArray[np.float32],
    points: NDArray[np.float64],
    things: Iterable[NDArray[np.bool_]],
    walls: Sequence[Wall],
    error: DepthError,
) -> NDArray[np.float32]:
    """Depth (H, W), unknown (0) where a thing that is before a wall shows what is behind it.

    Args:
        points: (H, W, 3) of the picture in the floor frame; NaN where not used.
        things: their pixels (H, W).
    """
    clean = depth.copy()
    for mask in things:
        known = mask & np.isfinite(points[..., 2])
        if not known.any():
            continue
        limit = BEHIND + REACH * error.at(depth[known].astype(np.float64))
        for wall in walls:
            behind = points[known] @ np.array(wall.normal) - wall.offset < -limit
            if AT_WALL <= (~behind).mean() < 1:
                clean[known] = np.where(behind, 0, clean[known])
    return clean
