"""Masks without any segmenter: what stands on a table or the floor, cut apart by distance, near things by shape too."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_fill_holes, binary_opening
from scipy.spatial import Delaunay, KDTree

from stages.contracts import InputError
from stages.geometry.cameras import back_project
from stages.geometry.clouds import dbscan
from stages.geometry.planes import Plane, fit_plane
from stages.inputs.rgbd.frame import Labelled
from stages.inputs.rgbd.halos import completed, without_halos
from stages.inputs.rgbd.levels import FLAT, Level, level_planes, sampled
from stages.inputs.rgbd.touching import cut_apart, smoothed

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
CEILING, SEVERAL = 2.2, 2  # metres: furniture is lower; things on a floor that make a room, not a table
WALLS, WALL_LEAST, WALL_BEHIND = 6, 0.03, 0.05  # planes tried; of all points, that a wall has, and that are behind it
WALL_ERROR = 0.02  # metres at 1 m before a wall that are still the wall
UPRIGHT, WIDE = np.sin(np.deg2rad(15)), 0.4  # a wall's normal along the level one's; metres


def clustered(
    depth: NDArray[np.float32], intrinsics: NDArray[np.float64], rgb: NDArray[np.uint8]
) -> tuple[Labelled, NDArray[np.float32]]:
    """Objects on the highest large level plane of a depth image (H, W), metres: each an `object`, from left to right.

    Farther away than a table, where several things stand on the floor, it is a room: objects on its floor, each with
    what stands on it. What is seen of walls behind them is a `wall`.

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
    is_near = far < NEAR
    levels = [plane for plane in level_planes(sample, rng) if plane.height(np.zeros(3)) > 0]  # no ceiling
    ground = _table(levels, sample, far) if is_near else _room(levels, sample, rng)
    heaps = _heaps(ground, sample, far)
    if not is_near and (heaps is None or len(heaps.kept) < SEVERAL):
        ground = _table(levels, sample, far)
        heaps = _heaps(ground, sample, far)
    elif not is_near:
        print("--clusters: a room: what stands on its floor is found, each with what it carries; draw the rest by hand")
    if heaps is None or not heaps.kept:
        raise InputError("--clusters", "nothing of some size stands on the level plane.", "give --masks")
    table, clusters, kept = ground.level, heaps.clusters, heaps.kept
    belongs = np.isin(clusters, kept)
    near, which = KDTree(heaps.points[belongs]).query(cloud, distance_upper_bound=heaps.radius)
    own = np.isfinite(near) & ground.holds(cloud, far)
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
    if is_near:
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
    for value, wall in enumerate(ground.walls, max(labels, default=0) + 1):
        at_wall = seen & (values == 0) & (np.abs(points @ wall.normal - wall.offset) < WALL_ERROR * far)
        values[at_wall & (table.height(points) > ABOVE * far)] = value
        labels[value] = WALL
    return Labelled(values, labels), depth


class Ground(NamedTuple):
    """A level plane on which things stand; the part of it that they stand on, if not all, and the walls around."""

    level: Level
    hull: Delaunay | None
    walls: list[Plane]

    def holds(self, points: NDArray[np.float64], far: float) -> NDArray[np.bool_]:
        """Points (N,) that may be of things: over what is seen of a table; in a room, before its walls."""
        height = self.level.height(points)
        if self.hull is not None:
            over = self.hull.find_simplex(_across(self.level, points)) >= 0
            return (height > ABOVE * far) & (height < HIGHEST) & over
        before = np.all([wall.offset - points @ wall.normal > WALL_ERROR * far for wall in self.walls], axis=0)
        return np.asarray((height > ABOVE * far) & (height < CEILING) & before)


class Heaps(NamedTuple):
    """Points (N, 3) of things, the cluster of each, the radius that makes them, and the clusters that stand."""

    points: NDArray[np.float64]
    clusters: NDArray[np.int32]
    radius: float
    kept: list[int]


def _heaps(ground: Ground, sample: NDArray[np.float64], far: float) -> Heaps | None:
    """What stands on a ground; None if hardly anything is there."""
    above = sample[ground.holds(sample, far)]
    if len(above) < 10:
        return None
    spacing = float(np.quantile(KDTree(above).query(above, k=8)[0][:, -1], 0.9))
    radius = max(APART * far, 1.2 * spacing)
    clusters = dbscan(above, radius, 8)
    return Heaps(above, clusters, radius, _standing(ground.level, above, clusters, far, LEAST * len(sample)))


def _large(levels: list[Level]) -> dict[float, Level]:
    """The large level planes by how far they are below the camera, metres."""
    if not levels:
        raise InputError("--clusters", "no level plane below the camera was found.", "give --masks")
    large = [plane for plane in levels if plane.points >= LARGE * levels[0].points]
    return {float(plane.height(np.zeros(3))): plane for plane in large}


def _room(levels: list[Level], sample: NDArray[np.float64], rng: np.random.Generator) -> Ground:
    """The lowest of the large level planes, and its walls."""
    floor = max(_large(levels).items())[1]
    return Ground(floor, None, _walls(sample, floor.up, rng))


def _walls(points: NDArray[np.float64], up: NDArray[np.float64], rng: np.random.Generator) -> list[Plane]:
    """Upright planes behind which hardly any of the points (N, 3) are; their normals point away from the camera."""
    found: list[Plane] = []
    rest, far = points, float(np.median(points[:, 2]))
    for _ in range(WALLS):
        plane = fit_plane(rest, 2 * FLAT * far, 1000, rng, lambda normals: np.abs(normals @ up) < UPRIGHT)
        if plane is None or plane.inliers.sum() < WALL_LEAST * len(points):
            break
        sign = float(np.sign(plane.offset))
        if (sign * (points @ plane.normal - plane.offset) > BEHIND * far).mean() < WALL_BEHIND:
            found.append(Plane(sign * plane.normal, sign * plane.offset, plane.inliers))
        rest = rest[~plane.inliers]
    return found


def _table(levels: list[Level], sample: NDArray[np.float64], far: float) -> Ground:
    """The highest of the large level planes: a table rather than the floor that it stands on, or the lids on it."""
    large = _large(levels)
    tables = {
        down: plane
        for down, plane in large.items()
        if not any(plane.points < other.points and 0 < below - down < LEG for below, other in large.items())
    }
    table = min(tables.items())[1]
    return Ground(table, Delaunay(_across(table, sample[np.abs(table.height(sample)) < FLAT * far])), [])


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
