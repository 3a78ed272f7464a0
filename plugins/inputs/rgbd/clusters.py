"""Masks without a segmenter: what stands on a table or a floor, one mask for each cluster of points (DBSCAN)."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_fill_holes, binary_opening
from scipy.spatial import Delaunay, KDTree

from plugins.inputs.rgbd.edges import find_smooth_pixels
from plugins.inputs.rgbd.frame import Labelled
from stages.config.extraction import ExtractionConfig
from stages.contracts import InputError
from stages.contracts.types import WALL
from stages.geometry.cameras import back_project
from stages.geometry.clouds import dbscan
from stages.geometry.frames import apply
from stages.geometry.levels import OFF_LEVEL, TABLE_WITHIN, find_ground
from stages.geometry.planes import Plane
from stages.geometry.room_planes import find_walls, make_floor_frame, sample_points

TILT = 75.0  # degrees: largest angle between image-up and the ground's normal, as cameras look down at tables; chosen
MIN_SHARE = 0.001  # share of all points that an object has at least; chosen
Masks = list[NDArray[np.bool_]]


def make_clusters(depth: NDArray[np.float32], intrinsics: NDArray[np.float64]) -> Labelled:
    """Masks of things on the level plane that most of them stand on, all called `object`, and of the walls around it.

    Things that touch are one thing. From left to right.

    Args:
        depth: (H, W) metres, 0: unknown.
        intrinsics: (3, 3) pixels.

    Raises:
        InputError: there is no level plane, or nothing on it.
    """
    rng = np.random.default_rng(0)
    ground = find_ground(back_project(depth, intrinsics), depth > 0, TILT)
    things, walls = ([], []) if ground is None else _find_things(depth, intrinsics, ground, rng)
    if not things:
        raise InputError(
            "--clusters", "finds nothing that stands on a level plane.", "give --masks", code="E-MASKS-EMPTY"
        )
    values = np.zeros(depth.shape, dtype=np.uint16)
    for value, mask in enumerate([*sorted(things, key=lambda mask: np.nonzero(mask)[1].mean()), *walls], 1):
        values[mask & (values == 0)] = value
    return Labelled(values, dict(enumerate(["object"] * len(things) + [WALL] * len(walls), 1)))


def _find_things(
    depth: NDArray[np.float32], intrinsics: NDArray[np.float64], ground: Plane, rng: np.random.Generator
) -> tuple[Masks, Masks]:
    """Masks (H, W) of what stands on a level plane, and of the walls around it."""
    points = apply(make_floor_frame(ground), back_project(depth, intrinsics))
    seen = depth > 0
    off = OFF_LEVEL * float(np.median(depth[seen]))
    above = seen & (points[..., 2] > off)
    on_ground = seen & (np.abs(points[..., 2]) < off)
    walls = find_walls(points[seen], above[seen], -ground.offset, rng, off)
    heights = [points @ normal - offset for normal, offset, _ in walls]
    inside = np.logical_and.reduce([above, *(height > 2 * off for height in heights)])
    if np.median(depth[seen]) < TABLE_WITHIN:  # on a table nothing counts that is not over it
        inside &= Delaunay(sample_points(points[on_ground], rng)[:, :2]).find_simplex(points[..., :2]) >= 0
    inner = inside & (points[..., 2] > 2 * off) & find_smooth_pixels(depth, 2 * OFF_LEVEL)
    clusters = np.full(depth.shape, -1)
    clusters[inside] = _label_points(
        points[inside], points[inner], 2 * off, MIN_SHARE * seen.sum() / max(1, inner.sum()), rng
    )
    things = [binary_opening(clusters == name, np.ones((3, 3))) for name in np.unique(clusters[clusters >= 0])]
    at_walls = [above & (np.abs(height) < 2 * off) for height in heights]
    return [binary_fill_holes(mask) for mask in things if mask.any()], at_walls


def _label_points(
    points: NDArray[np.float64], inner: NDArray[np.float64], radius: float, least: float, rng: np.random.Generator
) -> NDArray[np.int32]:
    """Cluster (N,) of each of points (N, 3), -1: none. The `inner` points (M, 3) form them, each at least a share of
    `least`."""
    inner, neighbours = sample_points(inner, rng), ExtractionConfig().dbscan_min_points
    if len(inner) <= neighbours:
        return np.full(len(points), -1, dtype=np.int32)
    spacing = float(np.quantile(KDTree(inner).query(inner, k=neighbours)[0][:, -1], 0.9))
    names = dbscan(inner, max(radius, spacing), neighbours)
    large, counts = np.unique(names[names >= 0], return_counts=True)
    kept = np.isin(names, large[counts >= least * len(inner)])
    if not kept.any():
        return np.full(len(points), -1, dtype=np.int32)
    _, which = KDTree(inner[kept]).query(points, distance_upper_bound=max(radius, spacing))
    return np.append(names[kept], -1)[which]
