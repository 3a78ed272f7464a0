"""The cloud of one object and its box: outlier removal, DBSCAN, robust z-aligned box (paper A.7)."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import KDTree

from stages.config.extraction import ExtractionConfig
from stages.geometry.boxes import UprightBox
from stages.geometry.clouds import dbscan, statistical_inliers
from stages.geometry.estimate import BIN, PROMINENT
from stages.geometry.minimum_box import minimum_box

MAX_POINTS = 8000
NEIGHBOURS = 16
SPACING = 1.5  # DBSCAN's radius is at least so many times the distance to the `dbscan_min_points`-th neighbour
BEHIND = 1.5  # metres behind the farthest point of the largest cluster, from which on another is background
LEVEL_BLUR = 0.003  # share of the distance: noise of heights, seen from little above
ABOVE = 0.1  # share of the points that may lie above the level on which things stand
HIGHER = 0.1  # share of the distance, up to `NEAR`, by which they may be above it: a part of the thing is higher
SLENDER, NEAR = 2.0, 2.0  # times as tall as wide; metres, as farther away noise makes things taller
SPARSE = 0.95  # taken where points are sparse: faces that the camera sees at a grazing angle


def cleaned_cloud(
    points: NDArray[np.float64], options: ExtractionConfig, rng: np.random.Generator, eye: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Points (M, 3), M <= 8000, without stray ones.

    Every DBSCAN cluster of some size is kept, not only the largest: a pole in front of an object
    cuts its cloud in two. What lies well behind the largest is seen past the object, or through it.

    Args:
        eye: (3,) where the camera is.
    """
    if len(points) > MAX_POINTS:
        points = points[np.sort(rng.choice(len(points), MAX_POINTS, replace=False))]
    points = points[statistical_inliers(points, NEIGHBOURS, options.outlier_deviations)]
    if len(points) <= options.dbscan_min_points:
        return points
    distances, _ = KDTree(points).query(points, k=options.dbscan_min_points)
    radius = max(options.dbscan_eps, SPACING * float(np.quantile(distances[:, -1], SPARSE)))
    labels = dbscan(points, radius, options.dbscan_min_points)
    clusters, counts = np.unique(labels[labels >= 0], return_counts=True)
    kept = clusters[counts >= options.dbscan_keep * len(points)]
    if not len(kept):
        return points[:0]
    ranges = np.linalg.norm(points - eye, axis=1)
    end = ranges[labels == clusters[np.argmax(counts)]].max() + BEHIND
    return points[np.isin(labels, [cluster for cluster in kept if np.median(ranges[labels == cluster]) <= end])]


def fit_box(points: NDArray[np.float64], options: ExtractionConfig) -> UprightBox:
    """The z-aligned minimum box of a cleaned cloud, its extents as quantiles."""
    return minimum_box(points, options.trim)


def level_height(
    points: NDArray[np.float64],
    whole: NDArray[np.float64],
    box: UprightBox,
    noise: float,
    distance: float,
    options: ExtractionConfig,
) -> float | None:
    """Height of the highest level at which many of the points (N, 3) lie; None without one, or if it is no top.

    A table top gives many points of one height; a few higher ones are noise, or depth at the edges of things on it.
    The neck of a bottle is more than that, and nothing stands on what is far taller than wide.

    Args:
        points: without stray ones. whole: all that the mask shows. box: of the points.
        noise, distance: of depth, metres, and of the camera.
        options: the share of the points left out at either end, and the tolerance of heights.
    """
    heights = points[:, 2]
    low, high = np.quantile(heights, [options.trim, 1 - options.trim])
    bins = int((high - low) / BIN)
    is_slender = distance < NEAR and high - low > SLENDER * max(box.size[:2])
    if bins < 3 or is_slender:
        return None
    counts, edges = np.histogram(heights, bins, (low, high))
    blur = max(2.0, LEVEL_BLUR * distance / BIN)
    density = gaussian_filter1d(counts.astype(float), blur, mode="constant")
    peaks = np.flatnonzero((density >= np.roll(density, 1)) & (density >= np.roll(density, -1)))
    dense = peaks[density[peaks] > PROMINENT * len(heights) / bins]
    if not len(dense):
        return None
    level = float(edges[dense[-1]] + edges[dense[-1] + 1]) / 2
    above = whole[whole[:, 2] > level + 2 * blur * BIN]
    top = float(np.quantile(whole[:, 2], 1 - options.trim))
    is_whole = top - high <= options.tolerance(noise)  # else trusted points lack a thin top
    few = max(len(above) / len(whole), float((heights > level + 2 * blur * BIN).mean())) <= ABOVE
    return level if is_whole and few and top - level <= HIGHER * min(distance, NEAR) else None


def with_top(box: UprightBox, top: float) -> UprightBox:
    """The box with its top face moved to height `top`."""
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    center[2], size[2] = (top + box.bottom) / 2, top - box.bottom
    return UprightBox(center, size, box.yaw)


def with_bottom(box: UprightBox, bottom: float) -> UprightBox:
    """The box with its bottom face moved to height `bottom`."""
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    center[2], size[2] = (box.top + bottom) / 2, box.top - bottom
    return UprightBox(center, size, box.yaw)
