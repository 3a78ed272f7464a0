"""The cloud of an object: depth continued to its outline, without stray points (paper A.7); levels on which it carries.

Estimated depth is wrong along outlines, so masks are eroded (A.7). But without their border objects come out too small:
two pixels are 1 cm at 3 m on a face seen straight on, and 10 cm on a table top seen at a low angle. Inverse depth is
linear in the pixel on any plane, so it is continued from the core by local linear fits.
"""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import KDTree

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts.category import CategoryFacts
from roomkin.stages.extraction.contact import DepthView
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.clouds import dbscan, statistical_inliers
from roomkin.stages.geometry.frames import Array, yaw_matrix
from roomkin.stages.geometry.masks import OUTLINE, Mask, erode
from roomkin.stages.geometry.robust import BIN, PROMINENT
from roomkin.stages.geometry.room_planes import STRAY

LEVEL_BLUR = 0.003  # share of the distance: noise of heights, seen from little above; chosen
PLAN_CELLS = 16  # of a ground plan along either side; chosen
HIGHEST_POINTS = 3  # of a cell, the last of which is its height, as single ones are noise; chosen


def find_level(points: Array, box: UprightBox, distance: float) -> float | None:
    """The height of most of an object's upper surface, or where most of its front ends.

    Clutter, a backrest or a tap reach higher, but have fewer points. Candidates are heights with at least half as
    many points as the fullest one; the lowest carries the others and is taken. None: only a front is seen, or the
    level belongs to what the object stands on.

    Args:
        points: (N, 3) of the object, `distance` metres from the camera; their box.
    """
    heights = points[:, 2]
    low, high = float(heights.min()), float(heights.max())
    bins = int((high - low) / BIN)
    if bins < 3:
        return None
    blur = max(2.0, LEVEL_BLUR * distance / BIN)
    thick = 2 * blur * BIN
    upper = heights[is_uppermost(points, box, thick)]
    everywhere, above = (
        gaussian_filter1d(np.histogram(values, bins, (low, high))[0].astype(float), blur, mode="constant")
        for values in (heights, upper)
    )
    is_level = everywhere > PROMINENT * len(heights) / bins
    peaks = is_level & (above >= np.roll(above, 1)) & (above >= np.roll(above, -1))
    peaks &= above >= above.max() / 2
    peak = int(np.argmax(peaks if peaks.any() else above))
    height = low + (peak + 0.5) * (high - low) / bins
    higher = float((heights > height + thick).mean())
    is_front = not is_level[peak] and higher < STRAY
    is_base = height < np.quantile(heights, STRAY) + thick and higher > 0.5
    return None if is_front or is_base else height


def is_uppermost(points: Array, box: UprightBox, thick: float) -> NDArray[np.bool_]:
    """Which points (N, 3) are at most `thick` metres below the highest one over their cell of the ground plan."""
    inside = (points - box.center) @ yaw_matrix(box.yaw)[:, :2] / np.maximum(box.size[:2], 1e-6) + 0.5
    row, column = np.clip((inside * PLAN_CELLS).astype(int), 0, PLAN_CELLS - 1).T
    _, cells, counts = np.unique(row * PLAN_CELLS + column, return_inverse=True, return_counts=True)
    heights = points[np.lexsort((points[:, 2], cells)), 2]
    ends = heights[np.cumsum(counts) - np.minimum(counts, HIGHEST_POINTS)]
    return np.asarray(points[:, 2] > ends[cells] - thick)


def find_carrying_heights(category: CategoryFacts | None, level: float | None, top: float) -> tuple[float, ...]:
    """Heights at which an object may carry others, the likeliest first; its box ends at `top`.

    A chair carries at its seat, a desk between its clutter and on top of that, a shelf at its top alone.
    """
    has_boards = category is not None and category.carries == "boards"
    return (top,) if level is None or has_boards else (level, top)


MAX_POINTS = 8000  # of a cloud; chosen for time
NEIGHBOURS, MAX_DEVIATIONS = 16, 3.0  # of a point, and their distance in deviations of all distances: no outlier
RADIUS, CORE = 0.04, 8  # DBSCAN's, in metres and points (A.7); the radius grows where points are sparse
SPACING, SPARSE = 1.5, 0.95  # DBSCAN's radius in distances to a neighbour, at this quantile of the points; chosen
SMALL = 0.01  # share of an object's points: smaller clusters are dropped; chosen
# What begins so far behind the largest cluster, from above, and beside it in the picture, is seen past or through it:
# half of its diagonal, at least what touches, at most 25 cm. Chosen on `work`, whose true pixels are known.
BEHIND, FARTHEST_BEHIND = 0.5, 0.25
RIDGE = 0.1  # pixels squared, added to the variances of a fit: a core one pixel wide has none across it; chosen
BLUR_BLOCK = 32  # pixels that OpenCV blurs at once
MAX_CHANGE = 0.05  # largest relative change of depth from the core's local mean; chosen


class UnusableObjectError(Exception):
    """One object cannot be used; the scene goes on without it."""


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
        raise UnusableObjectError("no depth on its pixels")
    cloud = clean_cloud(cloud, view, rng)
    if len(cloud) < 3:
        raise UnusableObjectError("its depth is too scattered: no cluster of points")
    return cloud


def clean_cloud(points: Array, view: DepthView, rng: np.random.Generator) -> Array:
    """Points (M, 3), M <= 8000, without stray ones.

    Every DBSCAN cluster of some size is kept, not only the largest: a pole in front of an object cuts its cloud in
    two, and a lamp's pole has no depth. But not what is behind and beside it in the picture: a wall through a handle.

    `rng` chooses which points of a large cloud are left out.
    """
    if len(points) > MAX_POINTS:
        points = points[np.sort(rng.choice(len(points), MAX_POINTS, replace=False))]
    points = points[statistical_inliers(points, NEIGHBOURS, MAX_DEVIATIONS)]
    if len(points) <= CORE:
        return points
    distances, _ = KDTree(points).query(points, k=CORE)
    radius = max(RADIUS, SPACING * float(np.quantile(distances[:, -1], SPARSE)))
    labels = dbscan(points, radius, CORE)
    clusters, counts = np.unique(labels[labels >= 0], return_counts=True)
    large = clusters[counts >= SMALL * len(points)]
    parts = {cluster: points[labels == cluster] for cluster in large}
    largest = parts.get(clusters[np.argmax(counts)], points) if len(clusters) else points
    kept = [cluster for cluster, part in parts.items() if not is_behind(part, largest, view)]
    return points[np.isin(labels, kept)]


def is_behind(part: Array, largest: Array, view: DepthView) -> bool:
    """Whether a cluster (N, 3) is seen past the edge of the largest one (M, 3) of an object, or through it.

    What a nearer thing cuts off is not beside it in the picture; a lamp's foot is no farther from above than its shade.
    """
    eye, width = view.frame[:2, 3], float(np.linalg.norm(np.ptp(largest[:, :2], axis=0)))
    ends = float(np.quantile(np.linalg.norm(largest[:, :2] - eye, axis=1), 0.99))
    behind = float(np.median(np.linalg.norm(part[:, :2] - eye, axis=1))) - ends
    if behind < max(min(BEHIND * width, FARTHEST_BEHIND), 2 * view.tolerance(np.median(part, axis=0))):
        return False
    apart, _ = KDTree(view.project(largest)).query(view.project(part))
    return bool(apart.min() <= OUTLINE)


def _blur(values: Array) -> Array:
    """Local means; the standard deviation of the weights is as wide as a border."""
    return np.asarray(cv2.GaussianBlur(values, (0, 0), OUTLINE, borderType=cv2.BORDER_CONSTANT), dtype=np.float64)


def continue_depth(depth: NDArray[np.floating], core: Mask, border: Mask) -> Array:
    """Depth (H, W): the given one on `core`, continued on `border` where the core is near, 0 elsewhere.

    Args:
        depth: (H, W) metres; 0 where unknown.
        core: pixels with trusted depth.
        border: pixels whose depth is to be found.
    """
    continued = np.zeros(depth.shape)
    rows, columns = np.nonzero(core | border)
    if len(rows):
        reach = int(5 * OUTLINE) + 1  # of the weights
        # Whole blocks of pixels, which the processor takes together: the same bits as in the whole picture.
        ends = (
            (max(0, at.min() - reach) // BLUR_BLOCK, (at.max() + reach) // BLUR_BLOCK + 1) for at in (rows, columns)
        )
        window = tuple(slice(BLUR_BLOCK * first, BLUR_BLOCK * last) for first, last in ends)
        height, width = depth.shape
        v, u = np.meshgrid(np.arange(height) - height / 2, np.arange(width) - width / 2, indexing="ij")
        continued[window] = _extrapolate(depth[window], core[window], border[window], u[window], v[window])
    return continued


def _extrapolate(depth: NDArray[np.floating], core: Mask, border: Mask, u: Array, v: Array) -> Array:
    """The same in the part of the picture that holds core and border; u and v are its pixels."""
    known = core & (depth > 0)
    weight = known.astype(np.float64)
    inverse = np.where(known, 1 / np.maximum(depth, 1e-6), 0.0)
    total = np.maximum(_blur(weight), 1e-12)
    mean_u, mean_v, mean = (_blur(weight * field) / total for field in (u, v, inverse))
    var_u = _blur(weight * u * u) / total - mean_u**2 + RIDGE
    var_v = _blur(weight * v * v) / total - mean_v**2 + RIDGE
    cov_uv = _blur(weight * u * v) / total - mean_u * mean_v
    cov_u = _blur(u * inverse) / total - mean_u * mean
    cov_v = _blur(v * inverse) / total - mean_v * mean
    determinant = var_u * var_v - cov_uv**2
    slope_u = (var_v * cov_u - cov_uv * cov_v) / determinant
    slope_v = (var_u * cov_v - cov_uv * cov_u) / determinant
    fitted = mean + slope_u * (u - mean_u) + slope_v * (v - mean_v)
    fitted = np.clip(fitted, mean * (1 - MAX_CHANGE), mean * (1 + MAX_CHANGE))
    near = border & ~known & (total > 1e-3)
    return np.where(known, depth, np.where(near, 1 / np.maximum(fitted, 1e-6), 0.0))
