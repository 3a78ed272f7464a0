"""Which way is up in a picture with depth; floor, its frame, and walls by seeded RANSAC (paper 2.1, A.3)."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from roomkin.stages.geometry.frames import make_transform

IMAGE_UP = np.array([0.0, -1.0, 0.0])  # camera frame: y is down
CELLS = 64  # cells across a picture, a normal of each: enough noise is averaged out at 4 m of a stereo camera
MIN_KNOWN = 0.6  # share of a cell's pixels of known depth; below it lies at an edge or a hole
NOISE = 0.0025  # metres of depth at 1 m, growing with the square of the distance: of a stereo camera
WITHIN = np.sin(np.deg2rad(8))  # a surface counts as level or upright up to here: the error of a normal at 4 m
LEVEL = np.sqrt(1 - WITHIN**2)  # cosine of the same angle
NO_LEVEL, MUCH_LEVEL = 0.01, 0.1  # shares of a picture's cells that face up; right frames have 0.04 at least
ROUNDS = 10  # of the refinement; it stands still after three or four
Array = NDArray[np.float64]


def cell_normals(points: Array, known: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Centers (N, 3) and unit normals (N, 3), towards the camera, of the picture's flat cells.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels with depth.
    """
    side = max(2, points.shape[1] // CELLS)
    height, width = (length // side * side for length in known.shape)
    weight = known[:height, :width].astype(float)
    place = np.where(known[..., None], points, 0.0)[:height, :width]
    x, y, z = np.moveaxis(place, -1, 0)
    moments = np.stack([weight, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z], axis=-1)
    sums = moments.reshape(height // side, side, width // side, side, -1).mean(axis=(1, 3))
    sums = uniform_filter(sums, (3, 3, 1), mode="constant")  # of the 3 x 3 cells around each
    kept = sums[..., 0] > MIN_KNOWN
    mean = sums[kept][:, 1:] / sums[kept][:, :1]
    first, second = mean[:, :3], mean[:, [3, 4, 5, 4, 6, 7, 5, 7, 8]].reshape(-1, 3, 3)
    spread, axes = np.linalg.eigh(second - first[:, :, None] * first[:, None, :])
    flat = spread[:, 0] < np.minimum(0.5 * spread[:, 1], 0.02 * spread[:, 1] + (NOISE * first[:, 2] ** 2) ** 2)
    first, normals = first[flat], axes[flat][..., 0]
    return first, np.where(((first * normals).sum(-1) > 0)[:, None], -normals, normals)


def find_up(points: Array, known: NDArray[np.bool_], max_tilt: float) -> Array | None:
    """The unit vector (3,) against gravity in the camera frame; None: no surface tells.

    Args:
        points: (H, W, 3) camera frame, metres.
        known: (H, W) pixels with depth.
        max_tilt: largest angle to image-up, degrees.
    """
    return estimate_up(cell_normals(points, known)[1], max_tilt)


def is_upside_down(points: Array, known: NDArray[np.bool_], max_tilt: float) -> bool:
    """Whether nothing level faces up, and much does if the picture is turned over. Args as of `find_up`."""
    normals = cell_normals(points, known)[1]
    up, down = (_share_level(normals * [1, side, 1], max_tilt) for side in (1, -1))
    return up < NO_LEVEL and down > MUCH_LEVEL


def _share_level(normals: Array, max_tilt: float) -> float:
    up = estimate_up(normals, max_tilt)
    return 0.0 if up is None else float((normals @ up > LEVEL).mean())


def estimate_up(normals: Array, max_tilt: float) -> Array | None:
    """Likewise, by the normals of surfaces.

    A surface that faces up counts twice, an upright one and a ceiling once: a lone table top is upright, too, to
    every level direction.

    Args:
        normals: (N, 3) as of `cell_normals`.
        max_tilt: largest angle to image-up, degrees.
    """
    if len(normals) < 3:
        return None
    rng = np.random.default_rng(0)
    some = normals[rng.permutation(len(normals))[:1500]]
    pairs = np.cross(some, some[rng.permutation(len(some))])  # of two walls, where no level surface is seen
    tried = np.concatenate([some, -some, pairs, -pairs])
    lengths = np.linalg.norm(tried, axis=1)
    tried = tried[lengths > 0.5] / lengths[lengths > 0.5, None]
    tried = tried[tried @ IMAGE_UP > np.cos(np.deg2rad(max_tilt))]
    if not len(tried):
        return None
    along = tried @ some.T
    faces_up, others = along > LEVEL, (along < -LEVEL) | (np.abs(along) < WITHIN)
    up = tried[np.argmax((2 * faces_up.sum(axis=1) + others.sum(axis=1)) * (tried @ IMAGE_UP))]
    for _ in range(ROUNDS):
        along = normals @ up
        level, upright = normals[np.abs(along) > LEVEL], normals[np.abs(along) < WITHIN]
        axis = np.linalg.eigh(upright.T @ upright - level.T @ level)[1][:, 0]
        up = axis if axis @ up > 0 else -axis
    return up


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
        points: (N, 3); `threshold`: metres.
        iterations: number of three-point hypotheses, drawn from `rng`.
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
