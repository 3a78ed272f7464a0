"""The pixels and the cloud of one object: crop, erosion, outlier removal, DBSCAN (paper A.7)."""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from stages.config.extraction import ExtractionConfig
from stages.extraction.border import continue_depth
from stages.extraction.visibility import DepthView
from stages.geometry.clouds import dbscan, statistical_inliers
from stages.geometry.frames import Array
from stages.geometry.masks import MIN_PIXELS, Mask, central_crop, erode, remove_specks

MAX_POINTS = 8000  # of a cloud; chosen for time
MAX_CUT = 0.4  # share of an object's pixels outside the crop (A.7), above which it fails; chosen
NEIGHBOURS, MAX_DEVIATIONS = 16, 3.0  # of a point, and their distance in deviations of all distances: no outlier
SPACING, SPARSE = 1.5, 0.95  # DBSCAN's radius in distances to a neighbour, at this quantile of the points; chosen
SMALL = 0.01  # share of an object's points: smaller clusters are dropped; chosen


class ObjectError(Exception):
    """One object cannot be used; the scene goes on without it."""


def find_object_mask(whole: Mask, crop_share: float, is_known: bool) -> Mask:
    """An object's pixels (H, W) inside the crop, without specks; one whose box is known may be cut off by it.

    Raises:
        ObjectError: it has none, or too few.
    """
    if not whole.any():
        raise ObjectError("not in the picture: no pixel has its mask value")
    cropped = whole & central_crop(whole.shape, crop_share)
    inside = remove_specks(cropped)
    if not is_known and cropped.sum() < (1 - MAX_CUT) * whole.sum():
        raise ObjectError("cut off: too much of it is outside the central crop")
    if inside.sum() < MIN_PIXELS:
        raise ObjectError(f"too small or hidden: {int(inside.sum())} pixels")
    return inside


def make_object_cloud(mask: Mask, view: DepthView, options: ExtractionConfig, rng: np.random.Generator) -> Array:
    """The cleaned points (N, 3), floor frame, of a mask (H, W).

    Raises:
        ObjectError: too little depth is known of it.
    """
    core = erode(mask)
    if options.restore_border:
        view = replace(view, depth=continue_depth(view.depth, core, mask))
    cloud = view.of(mask if options.restore_border else core)
    if len(cloud) < 3:
        raise ObjectError("no depth on its pixels")
    cloud = clean_cloud(cloud, options, rng)
    if len(cloud) < 3:
        raise ObjectError("its depth is too scattered: no cluster of points")
    return cloud


def clean_cloud(points: Array, options: ExtractionConfig, rng: np.random.Generator) -> Array:
    """Points (M, 3), M <= 8000, without stray ones.

    Every DBSCAN cluster of some size is kept, not only the largest: a pole in front of an object
    cuts its cloud in two.

    `rng` chooses which points of a large cloud are left out.
    """
    if len(points) > MAX_POINTS:
        points = points[np.sort(rng.choice(len(points), MAX_POINTS, replace=False))]
    points = points[statistical_inliers(points, NEIGHBOURS, MAX_DEVIATIONS)]
    if len(points) <= options.dbscan_min_points:
        return points
    distances, _ = KDTree(points).query(points, k=options.dbscan_min_points)
    radius = max(options.dbscan_eps, SPACING * float(np.quantile(distances[:, -1], SPARSE)))
    labels = dbscan(points, radius, options.dbscan_min_points)
    clusters, counts = np.unique(labels[labels >= 0], return_counts=True)
    return points[np.isin(labels, clusters[counts >= SMALL * len(points)])]
