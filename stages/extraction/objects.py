"""One object as it is measured: its pixels, cloud (A.7: erosion, outliers, DBSCAN) and box, before what carries it."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from stages.config.extraction import ExtractionConfig
from stages.contracts.objects import SceneObject
from stages.contracts.scenes import Annotation
from stages.contracts.types import LARGEST
from stages.extraction.border import continue_depth
from stages.extraction.levels import fit_box_and_levels, is_seat
from stages.extraction.visibility import DepthView
from stages.geometry.boxes import UprightBox, round_off_box, surface_points
from stages.geometry.clouds import dbscan, statistical_inliers
from stages.geometry.frames import Array
from stages.geometry.masks import MIN_PIXELS, Mask, central_crop, erode, pixel_bounds, remove_specks

MAX_POINTS = 8000  # of a cloud; chosen for time
MAX_CUT = 0.4  # share of an object's pixels outside the crop (A.7), above which it fails; chosen
NEIGHBOURS, MAX_DEVIATIONS = 16, 3.0  # of a point, and their distance in deviations of all distances: no outlier
SPACING, SPARSE = 1.5, 0.95  # DBSCAN's radius in distances to a neighbour, at this quantile of the points; chosen
SMALL = 0.01  # share of an object's points: smaller clusters are dropped; chosen


class ObjectError(Exception):
    """One object cannot be used; the scene goes on without it."""


@dataclass(frozen=True)
class MeasuredObject:
    """An object and what the input states of it; if it did not fail its pixels (H, W), cloud (N, 3) and box, floor
    frame, the heights at which it may carry others, and whether it stands on the floor, as seats do."""

    object: SceneObject
    stated: Annotation
    mask: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    cloud: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    box: UprightBox | None = None
    heights: tuple[float, ...] = ()
    is_seat: bool = False

    def fail(self, reason: str) -> "MeasuredObject":
        """The object, failed."""
        update = {"status": "failed", "reason": reason, "points": 0}
        return MeasuredObject(self.object.model_copy(update=update), self.stated)


def measure_object(
    name: str,
    item: Annotation,
    whole: NDArray[np.bool_],
    view: DepthView,
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> MeasuredObject:
    """The pixels inside the crop, cloud and box of the object `name`; a box that the input states is kept.

    Args:
        whole: its pixels (H, W).
        rng: chooses which points of a large cloud are left out.
    """
    is_whole = item.box is not None and not item.guessed
    other = {"box", "guessed", "mounting", "proposals", "probabilities"}
    known = SceneObject(id=name, whole=is_whole, names=item.names, **item.model_dump(exclude=other))
    share, heights = None, tuple[float, ...]()
    try:
        mask = find_object_mask(whole, options.crop, item.box is not None)
        if item.box is not None:
            box = UprightBox(item.box.center, item.box.size, item.box.yaw)
            cloud = surface_points(box, MAX_POINTS)
            cloud = cloud if item.front is not None else round_off_box(cloud, box)
        else:
            share = round(float((view.depth[mask] > 0).mean()), 3)
            cloud = make_object_cloud(mask, view, options, rng)
            box, heights = fit_box_and_levels(item.label, cloud, mask, view, options.trim)
        extent = float(np.max(box.size))
        if extent > LARGEST:
            raise ObjectError(f"{extent:.0f} m large: its depth cannot be right")
    except ObjectError as failure:
        return MeasuredObject(known, item).fail(str(failure))
    seat = is_seat(item.label)
    seen = {"pixels": pixel_bounds(mask), "points": len(cloud), "depth_known": share}
    return MeasuredObject(known.model_copy(update=seen), item, mask, cloud, box, heights or (box.top,), seat)


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
