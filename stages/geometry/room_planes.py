"""Planes of a room: floor (or table top), the floor frame, and walls (paper 2.1, A.3)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stages.geometry.frames import rigid
from stages.geometry.gravity import IMAGE_UP
from stages.geometry.planes import Plane, fit_plane

MAX_POINTS = 20_000  # of a fit; chosen for time
MAX_PLANES = 4  # that are looked for; chosen
STRAY = 0.02  # share of points that may be noise, or seen in a mirror or through a window; chosen
PLANE_THRESHOLD = 0.03  # metres off a plane at 3 m: 1.8 times the usual error of depth there (contracts.objects)
SAME_DIRECTION = 10.0  # degrees: planes turned less against each other have one direction; chosen
GRAZING = 0.2  # sine of the angle between sight and a wall, 12 degrees: flatter, depth says little; chosen
WALL_TILT = 0.25  # largest |z| of a wall's unit normal: 14 degrees from upright; chosen
ITERATIONS = 1000  # of RANSAC: with 20 % inliers one misses the plane in 0.03 % of fits

Array = NDArray[np.float64]


class WallPlane(NamedTuple):
    """normal . p = offset in the floor frame; the unit normal (3,) is level and faces the camera; points on it."""

    normal: Array
    offset: float
    inliers: int


def sample_points(points: Array, rng: np.random.Generator) -> Array:
    """A random choice of at most `MAX_POINTS` points of (N, d), in their order."""
    if len(points) <= MAX_POINTS:
        return points
    return points[np.sort(rng.choice(len(points), MAX_POINTS, replace=False))]


def scale_threshold(points: Array, threshold: float) -> float:
    """A threshold given for 3 m, scaled to the median distance of points (N, 3) from the camera, the origin."""
    return threshold * max(1.0, float(np.median(np.linalg.norm(points, axis=1))) / 3.0)


def fit_floor(
    points: Array, max_tilt: float, rng: np.random.Generator, threshold: float = PLANE_THRESHOLD
) -> Plane | None:
    """The level plane with most inliers among points (N, 3), camera frame; its normal points up. None: there is none.

    Args:
        max_tilt: largest angle between image-up and its normal, degrees.
        threshold: metres within which a point at 3 m belongs to a plane.
    """
    if len(points) < 3:
        return None
    points, limit = sample_points(points, rng), np.cos(np.deg2rad(max_tilt))
    plane = fit_plane(
        points, scale_threshold(points, threshold), ITERATIONS, rng, lambda ups: np.abs(ups @ IMAGE_UP) > limit
    )
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
    return rigid(rotation, [0.0, 0.0, -floor.offset])


def fit_wall(
    points: Array, camera_height: float, rng: np.random.Generator, threshold: float = PLANE_THRESHOLD
) -> WallPlane | None:
    """The upright plane with most inliers among points (N, 3), floor frame; None: there is none.

    The camera is at (0, 0, camera_height); `threshold` as of `fit_floor`.
    """
    if len(points) < 3:
        return None
    points = sample_points(points, rng)
    off = scale_threshold(points - [0, 0, camera_height], threshold)
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
    points: Array,
    free: NDArray[np.bool_],
    camera_height: float,
    rng: np.random.Generator,
    threshold: float = PLANE_THRESHOLD,
) -> list[WallPlane]:
    """Walls without a mask: upright planes behind which nothing is seen.

    `points` (N, 3) of the whole picture, floor frame; `free` (N,): candidates; others: see `fit_wall`.
    """
    kept = np.sort(rng.permutation(len(points))[:MAX_POINTS])
    points, rest = points[kept], points[kept[free[kept]]]
    reach, found = scale_threshold(points - [0, 0, camera_height], threshold), []
    for _ in range(MAX_PLANES):
        wall = fit_wall(rest, camera_height, rng, threshold)
        if wall is None or wall.inliers < max(3, STRAY * len(points)):
            break
        distances = rest @ wall.normal - wall.offset
        near = rest[np.abs(distances) < reach]
        faces = -wall.offset > GRAZING * float(np.median(np.linalg.norm(near[:, :2], axis=1)))
        if faces and (points @ wall.normal - wall.offset < -2 * reach).mean() < STRAY:
            found.append(wall)
        rest = rest[distances > reach]
    return found
