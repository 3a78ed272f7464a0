"""Remove depth of reflections: a mirror or a window shows things that seem to lie behind its wall."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from stages.contracts.objects import DepthError, Wall
from stages.geometry.cameras import PointMap
from stages.geometry.estimate import REACH

IN_ROOM = 0.2  # share of a thing's points before a wall's plane, from which on it is in this room; chosen
NICHE = 0.3  # metres: no niche in a wall is deeper; chosen


def remove_reflections(
    depth: NDArray[np.float32],
    seen: PointMap,
    things: Iterable[NDArray[np.bool_]],
    walls: Sequence[Wall],
    error: DepthError,
) -> NDArray[np.float32]:
    """Depth (H, W), set to unknown (0) where an object of this room shows points behind a wall.

    Args:
        seen: what is used of the picture, floor frame.
        things: their pixels (H, W).
    """
    clean = depth.copy()
    for mask in things:
        known = mask & seen.known
        if not known.any():
            continue
        limit = NICHE + REACH * error.predict(depth[known].astype(np.float64))
        for wall in walls:
            behind = seen.of(known) @ np.array(wall.normal) - wall.offset < -limit
            if IN_ROOM <= (~behind).mean() < 1:
                clean[known] = np.where(behind, 0, clean[known])
    return clean
