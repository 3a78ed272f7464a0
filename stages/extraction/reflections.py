"""Remove depth of reflections: a mirror or a window shows things that seem to lie behind its wall."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.objects import DepthError, Wall
from roomkin.stages.extraction.contact import CONTACT_DISTANCE
from roomkin.stages.geometry.cameras import PointMap
from roomkin.stages.geometry.estimate import REACH

IN_ROOM = 0.2  # share of a thing's points before a wall's plane, from which on it is in this room; chosen
NICHE = 0.3  # metres: no niche in a wall is deeper; chosen


def remove_reflections(
    depth: NDArray[np.float32],
    seen: PointMap,
    things: Iterable[tuple[NDArray[np.bool_], Sequence[Wall]]],
    walls: Sequence[Wall],
    error: DepthError,
) -> NDArray[np.float32]:
    """Depth (H, W), set to unknown (0) where an object of this room shows points behind a wall.

    Of what hangs on that wall, even little behind it: sensors smear depth between a mirror's frame and what it shows.
    What is seen wholly behind a wall is in another room; but if it hangs, it is on that wall.

    Args:
        seen: what is used of the picture, floor frame.
        things: their pixels (H, W), and the walls at which they may hang.
    """
    clean = depth.copy()
    for mask, hung in things:
        known = mask & seen.known
        if not known.any():
            continue
        far = depth[known].astype(np.float64)
        noise, nearest = REACH * error.predict(far), np.full(len(far), np.inf)
        for wall in walls:
            before = seen.of(known) @ np.array(wall.normal) - wall.offset
            in_room = before[before >= -NICHE - noise]
            on_wall = len(in_room) > 0 and abs(np.median(in_room)) < CONTACT_DISTANCE + np.median(noise)
            behind = before < -noise - (0.0 if on_wall else NICHE)
            if IN_ROOM <= (~behind).mean() < 1:
                clean[known] = np.where(behind, 0, clean[known])
            height = float(seen.frame[:3, 3] @ np.array(wall.normal)) - wall.offset  # of the camera, before the wall
            if wall in hung and (~behind).mean() < IN_ROOM and height > 0:
                nearest = np.minimum(nearest, far * height / (height - np.minimum(before, 0)))
        if np.isfinite(nearest).all():
            clean[known] = nearest
    return clean
