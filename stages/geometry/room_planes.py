"""Planes by seeded RANSAC and least squares: floor (or table top), the floor frame, and walls (paper 2.1, A.3)."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.geometry.gravity import IMAGE_UP

MAX_POINTS = 20_000  # of a fit; chosen for time
MAX_PLANES = 4  # that are looked for; chosen
STRAY = 0.02  # share of points that may be noise, or seen in a mirror or through a window; chosen
PLANE_THRESHOLD = 0.03  # metres off a plane at 3 m: 1.8 times the usual error of depth there (contracts.objects)
SAME_DIRECTION = 10.0  # degrees: planes turned less against each other have one direction; chosen
GRAZING = 0.2  # sine of the angle between sight and a wall, 12 degrees: flatter, depth says little; chosen
WALL_TILT = 0.25  # largest |z| of a wall's unit normal: 14 degrees from upright; chosen
SCORED_POINTS = 2000  # hypotheses are scored on so many, the refinement uses all; chosen for time
ITERATIONS = 1000  # of RANSAC: with 20 % inliers one misses the plane in 0.03 % of fits

SAME_PLACE = 0.15  # metres: walls of one direction that are nearer than that are one; chosen

Array = NDArray[np.float64]


class Plane(NamedTuple):
    """Points p with normal . p = offset; `inliers` is a boolean mask over the fitted points."""

    normal: NDArray[np.float64]
    offset: float
    inliers: NDArray[np.bool_]


class WallPlane(NamedTuple):
    """normal . p = offset in the floor frame; the unit normal (3,) is level and faces the camera; points on it."""

    normal: Array
    offset: float
    inliers: int


def least_squares_plane(points: NDArray[np.floating]) -> tuple[NDArray[np.float64], float]:
    """Unit normal and offset of the plane with the least sum of squared distances to the points (N >= 3, 3)."""
    center = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - center, full_matrices=False)
    return axes[2], float(axes[2] @ center)


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


def sample_points(points: Array, rng: np.random.Generator) -> Array:
    """A random choice of at most `MAX_POINTS` points of (N, d), in their order."""
    if len(points) <= MAX_POINTS:
        return points
    return points[np.sort(rng.choice(len(points), MAX_POINTS, replace=False))]


def scale_threshold(points: Array) -> float:
    """`PLANE_THRESHOLD`, given for 3 m, scaled to the median distance of points (N, 3) from the camera, the origin."""
    return PLANE_THRESHOLD * max(1.0, float(np.median(np.linalg.norm(points, axis=1))) / 3.0)


def fit_floor(points: Array, max_tilt: float, rng: np.random.Generator) -> Plane | None:
    """The level plane with most inliers among points (N, 3), camera frame; its normal points up. None: there is none.

    Args:
        max_tilt: largest angle between image-up and its normal, degrees.
    """
    if len(points) < 3:
        return None
    points, limit = sample_points(points, rng), np.cos(np.deg2rad(max_tilt))
    off = scale_threshold(points)
    plane = fit_plane(points, off, ITERATIONS, rng, lambda ups: np.abs(ups @ IMAGE_UP) > limit)
    if plane is None or plane.normal @ IMAGE_UP >= 0:
        return plane
    return Plane(-plane.normal, -plane.offset, plane.inliers)


def make_floor_frame(floor: Plane) -> Array:
    """`floor_from_camera` (4, 4): z along the floor's normal, origin below the camera, x along the view."""
    up = floor.normal
    forward = np.array([0.0, 0.0, 1.0])
    x = forward - (forward @ up) * up
    if np.linalg.norm(x) < 1e-3:  # the camera looks straight down: image-up is ahead
        x = IMAGE_UP - (IMAGE_UP @ up) * up
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(up, x), up])
    return make_transform(rotation, [0.0, 0.0, -floor.offset])


def fit_wall(points: Array, camera_height: float, rng: np.random.Generator) -> WallPlane | None:
    """The upright plane with most inliers among points (N, 3), floor frame; None: there is none.

    The camera is at (0, 0, camera_height).
    """
    if len(points) < 3:
        return None
    points = sample_points(points, rng)
    off = scale_threshold(points - [0, 0, camera_height])
    plane = fit_plane(points, off, ITERATIONS, rng, lambda normals: np.abs(normals[:, 2]) < WALL_TILT)
    if plane is None:
        return None
    normal = plane.normal * [1, 1, 0]
    normal /= np.linalg.norm(normal)
    offset = float(np.median(points[plane.inliers] @ normal))
    if offset > 0:  # the camera, above the origin, is on the side that the normal faces
        normal, offset = -normal, -offset
    return WallPlane(normal, offset, int(plane.inliers.sum()))


def find_walls(
    points: Array, free: NDArray[np.bool_], camera_height: float, rng: np.random.Generator
) -> list[WallPlane]:
    """Walls without a mask: upright planes behind which nothing is seen.

    `points` (N, 3) of the whole picture, floor frame; `free` (N,): candidates; others: see `fit_wall`.
    """
    kept = np.sort(rng.permutation(len(points))[:MAX_POINTS])
    points, rest = points[kept], points[kept[free[kept]]]
    reach, found = scale_threshold(points - [0, 0, camera_height]), []
    for _ in range(MAX_PLANES):
        wall = fit_wall(rest, camera_height, rng)
        if wall is None or wall.inliers < max(3, STRAY * len(points)):
            break
        distances = rest @ wall.normal - wall.offset
        near = rest[np.abs(distances) < reach]
        faces = -wall.offset > GRAZING * float(np.median(np.linalg.norm(near[:, :2], axis=1)))
        if faces and (points @ wall.normal - wall.offset < -2 * reach).mean() < STRAY:
            found.append(wall)
        rest = rest[distances > reach]
    return found


def merge_walls(planes: Sequence[WallPlane]) -> tuple[list[WallPlane], list[int]]:
    """One wall for all planes that are the same, left and right of a cupboard say; and which of them each plane is."""
    merged: list[WallPlane] = []
    places = []
    for plane in planes:
        for k, other in enumerate(merged):
            same_way = plane.normal @ other.normal > np.cos(np.deg2rad(SAME_DIRECTION))
            if same_way and abs(plane.offset - other.offset) < SAME_PLACE:
                total = plane.inliers + other.inliers
                mean = plane.normal * plane.inliers + other.normal * other.inliers
                offset = (plane.offset * plane.inliers + other.offset * other.inliers) / total
                merged[k] = WallPlane(mean / np.linalg.norm(mean), offset, total)
                break
        else:
            k = len(merged)
            merged.append(plane)
        places.append(k)
    return merged, places
