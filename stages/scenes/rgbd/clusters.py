"""Masks without any segmenter: what stands on a table or the floor, cut apart by distance, near things by shape too."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_fill_holes, binary_opening
from scipy.spatial import Delaunay, KDTree

from stages.contracts import InputError
from stages.geometry.cameras import back_project
from stages.geometry.clouds import dbscan
from stages.geometry.planes import fit_plane
from stages.scenes.rgbd.frame import Labelled
from stages.scenes.rgbd.halos import completed, without_halos
from stages.scenes.rgbd.levels import FLAT, Level, level_planes, sampled
from stages.scenes.rgbd.touching import cut_apart, smoothed

ABOVE, HIGHEST = 0.010, 0.8  # metres: at 1 m, above the plane; not beyond
APART = 0.012  # metres at 1 m between two objects
LOWEST = 0.025  # metres at 1 m: what is nowhere nearer to the plane hangs over it, or stands behind it
LARGE, LEAST = 0.15, 0.002  # of the largest plane's points, for a table; of all points, for an object
LEG = 0.25  # metres: a plane nearer above a larger one is made of things that stand on it
NEAR = 2.0  # metres to what is looked at: things on a table. Furniture is not convex: shelves, legs, cushions
FIRM = 0.02  # metres at 1 m above the plane, from which on no noise of the plane is taken for an edge
LABEL, WALL = "object", "wall"
PLANE, SOME = 0.8, 0.02  # of a wall's points in a plane; of all points, that may be behind it
BEHIND = 0.03  # metres at 1 m, from which on they are
UPRIGHT, WIDE = np.sin(np.deg2rad(15)), 0.4  # a wall's normal along the level one's; metres


def clustered(
    depth: NDArray[np.float32], intrinsics: NDArray[np.float64], rgb: NDArray[np.uint8]
) -> tuple[Labelled, NDArray[np.float32]]:
    """Objects on the highest large level plane of a depth image (H, W), metres: each an `object`, from left to right.

    What is seen of walls behind them is a `wall`.

    The picture (H, W, 3) only tells where they end, beside the table. With them comes the depth, unknown (0) where it
    is the table's on what has a thing's colours.

    Raises:
        InputError: there is no level plane, or nothing on it.
    """
    rng = np.random.default_rng(0)
    seen = depth > 0
    cloud = back_project(depth, intrinsics)[seen]
    sample = sampled(cloud, rng)
    far = float(np.median(sample[:, 2]))
    table = _table(level_planes(sample, rng))
    hull = Delaunay(_across(table, sample[np.abs(table.height(sample)) < FLAT * far]))
    above = sample[_over(table, hull, sample, far)]
    if len(above) < 10:
        raise InputError("--clusters", "nothing stands on the level plane.", "give --masks")
    spacing = float(np.quantile(KDTree(above).query(above, k=8)[0][:, -1], 0.9))
    radius = max(APART * far, 1.2 * spacing)
    clusters = dbscan(above, radius, 8)
    kept = _standing(table, above, clusters, far, LEAST * len(sample))
    if not kept:
        raise InputError("--clusters", "nothing of some size stands on the level plane.", "give --masks")
    belongs = np.isin(clusters, kept)
    near, which = KDTree(above[belongs]).query(cloud, distance_upper_bound=radius)
    own = np.isfinite(near) & _over(table, hull, cloud, far)
    number = {name: value for value, name in enumerate(kept, 1)}
    assigned = np.zeros(len(cloud), dtype=np.uint16)
    assigned[own] = [number[int(clusters[belongs][k])] for k in which[own]]
    values = np.zeros(depth.shape, dtype=np.uint16)
    values[seen] = assigned
    for value in number.values():  # without hairs; the inside of a bowl lies on the table, too, and belongs to it
        core = binary_opening(values == value, np.ones((3, 3)))
        mask = binary_fill_holes(binary_closing(core, np.ones((7, 7))))
        values[(values == value) & ~mask] = 0
        values[mask & (values == 0)] = value
    if far < NEAR:
        points = back_project(smoothed(depth), intrinsics)
        height = table.height(points)
        values = cut_apart(values, points, height, FIRM * far)
        flat = seen & (np.abs(height) < ABOVE * far)
        measured = without_halos(values, rgb, flat | ~seen)
        values = completed(measured, rgb, flat)
        depth = np.where((values > 0) & (measured == 0), np.float32(0), depth)
    points = back_project(depth, intrinsics)
    labels = {}
    for value in np.unique(values[values > 0]).tolist():
        own, others = (sampled(points[(depth > 0) & where], rng) for where in (values == value, values != value))
        labels[value] = WALL if _is_wall(own, others, table.up, rng) else LABEL
    return Labelled(values, labels), depth


def _table(levels: list[Level]) -> Level:
    """The highest of the large level planes: a table rather than the floor that it stands on, or the lids on it."""
    if not levels:
        raise InputError("--clusters", "no level plane was found.", "give --masks")
    large = [plane for plane in levels if plane.points >= LARGE * levels[0].points]
    down = [float(plane.height(np.zeros(3))) for plane in large]  # metres below the camera
    lids = [
        any(one.points < other.points and 0 < below - above < LEG for other, below in zip(large, down, strict=True))
        for one, above in zip(large, down, strict=True)
    ]
    tables = [(above, plane) for above, plane, lid in zip(down, large, lids, strict=True) if not lid]
    return min(tables, key=lambda entry: entry[0])[1]


def _standing(
    table: Level, points: NDArray[np.float64], clusters: NDArray[np.int32], far: float, least: float
) -> list[int]:
    """Clusters of some size that reach down to the table, from left to right."""
    names, counts = np.unique(clusters[clusters >= 0], return_counts=True)
    heights = table.height(points)
    kept = [
        int(name)
        for name, count in zip(names, counts, strict=True)
        if count >= least and heights[clusters == name].min() < LOWEST * far
    ]
    return sorted(kept, key=lambda name: float((points[clusters == name, 0] / points[clusters == name, 2]).mean()))


def _is_wall(
    points: NDArray[np.float64], others: NDArray[np.float64], up: NDArray[np.float64], rng: np.random.Generator
) -> bool:
    """Whether points (N, 3) are those of a wide upright plane, with hardly any of the others behind it."""
    far = float(np.median(points[:, 2])) if len(points) else 0.0
    plane = fit_plane(points, 2 * FLAT * far, 300, rng, lambda normals: np.abs(normals @ up) < UPRIGHT)
    if plane is None or plane.inliers.mean() < PLANE:
        return False
    behind = np.sign(plane.offset) * (others @ plane.normal - plane.offset) > BEHIND * far
    return bool(np.ptp(points[plane.inliers] @ np.cross(plane.normal, up)) > WIDE and behind.mean() < SOME)


def _across(plane: Level, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (N, 2) in the plane."""
    return np.asarray(points @ np.linalg.svd(plane.up[None])[2][1:].T)


def _over(plane: Level, hull: Delaunay, points: NDArray[np.float64], far: float) -> NDArray[np.bool_]:
    """Points (N,) that lie above the plane, over the part of it that is seen."""
    height = plane.height(points)
    return (height > ABOVE * far) & (height < HIGHEST) & (hull.find_simplex(_across(plane, points)) >= 0)
