"""Depth that is wrong: reflections are removed, and the error is estimated from floor and walls, which are flat."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.stats import norm

from roomkin.stages.contracts.objects import USUAL_ERROR, DepthError, Wall
from roomkin.stages.extraction.contact import CONTACT_DISTANCE
from roomkin.stages.extraction.floor import ROUGH
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.geometry.frames import PointMap
from roomkin.stages.geometry.masks import erode
from roomkin.stages.geometry.robust import REACH
from roomkin.stages.geometry.room_planes import GRAZING, PLANE_THRESHOLD

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


PARTS = 8  # of a plane, by distance; chosen
MIN_POINTS = 100  # points of a part: their median deviation errs by 12 %


class PlanarPatch(NamedTuple):
    """Points (N, 3) of one plane, floor frame, and that plane: normal . p = offset."""

    points: NDArray[np.floating]
    normal: NDArray[np.floating]
    offset: float


def estimate_depth_error(image: AnnotatedImage, seen: PointMap, walls: Mapping[int, Wall]) -> DepthError:
    """The error of a picture's depth: as its source states it, else measured at the floor, else at the walls.

    The floor comes first: one mask of a person's may show two walls. Where neither is seen it is the usual error.

    Args:
        seen: what is used of the picture, floor frame.
        walls: by the mask values that show them.
    """
    if image.depth_error is not None:
        return image.depth_error
    if image.annotations.floor is not None:
        floor = image.masks == image.annotations.floor
    else:
        floor = (np.abs(seen.points[..., 2]) < PLANE_THRESHOLD) & ~np.isin(image.masks, image.annotations.values)
    shown = [(floor, [0.0, 0.0, 1.0], 0.0)]
    shown += [(image.masks == value, list(wall.normal), wall.offset) for value, wall in walls.items()]
    surfaces = [
        PlanarPatch(seen.of(erode(mask & seen.known, keep=0)), np.array(n), offset) for mask, n, offset in shown
    ]
    eye = seen.frame[:3, 3]
    return measure_error(surfaces[:1], eye) or measure_error(surfaces[1:], eye) or USUAL_ERROR


def measure_error(surfaces: Sequence[PlanarPatch], eye: NDArray[np.float64]) -> DepthError | None:
    """The error of the depth of surfaces seen from `eye` (3,); None if they are too small or no planes.

    Each is cut into parts by distance; a and b are the least squares, not negative, over the deviations of the parts.
    """
    distances, deviations = [], []
    for points, normal, offset in surfaces:
        rays = points - eye
        ranges = np.linalg.norm(rays, axis=1)
        slope = rays @ normal / ranges
        seen = np.abs(slope) > GRAZING  # else its own unevenness looks like an error of depth
        off, ranges = np.abs((points @ normal - offset)[seen] / slope[seen]), ranges[seen]
        for part in np.array_split(np.argsort(ranges), PARTS):
            if len(part) >= MIN_POINTS:
                distances.append(float(np.mean(ranges[part])))
                deviations.append(float(np.median(off[part]) / norm.ppf(0.75)))
    if not distances or np.median(np.divide(deviations, distances)) > ROUGH:
        return None
    (a, b), _ = nnls(np.column_stack([np.ones(len(distances)), np.square(distances)]), np.array(deviations))
    return DepthError(round(float(a), 6), round(float(b), 6))
