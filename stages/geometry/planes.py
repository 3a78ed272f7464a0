"""Plane fitting: seeded RANSAC in one vectorised pass, refined by least squares on the inliers."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SCORED_POINTS = 2000  # hypotheses are scored on so many, the refinement uses all; chosen for time


class Plane(NamedTuple):
    """Points p with normal . p = offset; `inliers` is a boolean mask over the fitted points."""

    normal: NDArray[np.float64]
    offset: float
    inliers: NDArray[np.bool_]


def least_squares_plane(points: NDArray[np.floating]) -> tuple[NDArray[np.float64], float]:
    """Unit normal and offset of the plane with the least sum of squared distances to the points (N >= 3, 3)."""
    centre = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre, full_matrices=False)
    return axes[2], float(axes[2] @ centre)


def fit_plane(
    points: NDArray[np.floating],
    threshold: float,
    iterations: int,
    rng: np.random.Generator,
    plausible: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None,
) -> Plane | None:
    """The plane with the most points within `threshold` of it.

    Args:
        points: (N, 3).
        threshold: inlier distance in metres.
        iterations: number of three-point hypotheses.
        rng: source of the hypotheses; the same state gives the same plane.
        plausible: which of (M, 3) unit normals may be a solution, e.g. nearly vertical ones.

    Returns:
        the refined plane (sign of the normal arbitrary), or None if no hypothesis holds three points.
    """
    points = np.asarray(points, dtype=float)
    if len(points) < 3:
        return None
    a, b, c = points[rng.integers(len(points), size=(3, iterations))]
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    valid = lengths > 1e-9
    normals, anchors = normals[valid] / lengths[valid, None], a[valid]
    if plausible is not None:
        keep = plausible(normals)
        normals, anchors = normals[keep], anchors[keep]
    if len(normals) == 0:
        return None
    offsets = np.einsum("ij,ij->i", normals, anchors)
    sample = points if len(points) <= SCORED_POINTS else points[rng.choice(len(points), SCORED_POINTS, replace=False)]
    best = np.argmax((np.abs(sample @ normals.T - offsets) < threshold).sum(axis=0))
    normal, offset = normals[best], float(offsets[best])
    for _ in range(2):  # refined inliers give a better plane, which gives better inliers
        inliers = np.abs(points @ normal - offset) < threshold
        if inliers.sum() < 3:
            return None
        refined, refined_offset = least_squares_plane(points[inliers])
        if plausible is not None and not plausible(refined[None])[0]:
            break
        normal, offset = refined, refined_offset
    return Plane(normal, offset, np.abs(points @ normal - offset) < threshold)
