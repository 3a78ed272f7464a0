"""Estimate the error of depth from the planes in the picture: floor and walls are flat, their measured depth is not."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.stats import norm

from roomkin.stages.contracts.objects import USUAL_ERROR, DepthError, Wall
from roomkin.stages.extraction.floor import ROUGH
from roomkin.stages.extraction.observation import AnnotatedImage
from roomkin.stages.geometry.cameras import PointMap
from roomkin.stages.geometry.masks import erode
from roomkin.stages.geometry.room_planes import GRAZING, PLANE_THRESHOLD

PARTS = 8  # of a plane, by distance; chosen
MIN_POINTS = 100  # points of a part: their median deviation errs by 12 %


class Surface(NamedTuple):
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
    surfaces = [Surface(seen.of(erode(mask & seen.known, keep=0)), np.array(n), offset) for mask, n, offset in shown]
    eye = seen.frame[:3, 3]
    return measure_error(surfaces[:1], eye) or measure_error(surfaces[1:], eye) or USUAL_ERROR


def measure_error(surfaces: Sequence[Surface], eye: NDArray[np.float64]) -> DepthError | None:
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
