"""The cloud of one object and its box: outlier removal, DBSCAN, robust z-aligned box (paper A.7)."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from stages.config.extraction import ExtractionConfig
from stages.geometry.boxes import UprightBox
from stages.geometry.clouds import dbscan, statistical_inliers
from stages.geometry.minimum_box import minimum_box

MAX_POINTS = 8000
NEIGHBOURS = 16
SPACING = 1.5  # DBSCAN's radius is at least so many times the distance to the `dbscan_min_points`-th neighbour
BEHIND = 1.5  # metres behind the farthest point of the largest cluster, from which on another is background
THINNEST = 0.01  # metres; noise may put a plate's top below the table's
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


def with_top(box: UprightBox, top: float) -> UprightBox:
    """The box with its top face moved to height `top`, its bottom face kept below that."""
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    bottom = min(box.bottom, top - THINNEST)
    center[2], size[2] = (top + bottom) / 2, top - bottom
    return UprightBox(center, size, box.yaw)


def with_bottom(box: UprightBox, bottom: float) -> UprightBox:
    """The box with its bottom face moved to height `bottom`."""
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    center[2], size[2] = (box.top + bottom) / 2, box.top - bottom
    return UprightBox(center, size, box.yaw)
