"""Floor and wall planes, and the floor frame they define (paper 2.1, A.3)."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from stages.config.extraction import ExtractionConfig
from stages.contracts.objects import Wall
from stages.geometry.frames import rigid
from stages.geometry.planes import Plane, fit_plane

UP_IN_IMAGE = np.array([0.0, -1.0, 0.0])  # camera frame: y is down
MAX_POINTS = 20_000
FALLBACK_PLANES = 4
STRAY = 0.02  # share of some points that say nothing: noise, what mirrors and windows show
GRAZING = 0.2  # sine of the angle between sight and a wall without a mask, below which it is the edge of something
WALL_TILT = 0.25  # largest |z| of a wall's unit normal, 14 degrees from upright


def sampled(points: NDArray[np.float64], rng: np.random.Generator, count: int = MAX_POINTS) -> NDArray[np.float64]:
    """At most `count` of the points, in their order."""
    if len(points) <= count:
        return points
    return points[np.sort(rng.choice(len(points), count, replace=False))]


def _threshold(points: NDArray[np.float64], options: ExtractionConfig) -> float:
    distance = float(np.median(np.linalg.norm(points, axis=1)))
    return options.plane_threshold * max(1.0, distance / 3.0)


def _upright(options: ExtractionConfig) -> Callable[[NDArray[np.float64]], NDArray[np.bool_]]:
    limit = np.cos(np.deg2rad(options.max_tilt))
    return lambda normals: np.abs(normals @ UP_IN_IMAGE) > limit


def fit_floor(points: NDArray[np.float64], options: ExtractionConfig, rng: np.random.Generator) -> Plane | None:
    """The plane of the floor mask's points (N, 3), camera frame; its normal points up."""
    if len(points) < 3:
        return None
    points = sampled(points, rng)
    return _face_up(
        fit_plane(points, _threshold(points, options), options.ransac_iterations, rng, plausible=_upright(options))
    )


def level_planes(points: NDArray[np.float64], options: ExtractionConfig, rng: np.random.Generator) -> list[Plane]:
    """Level planes below the camera in points (N, 3), camera frame: floors and table tops, one after the other."""
    found: list[Plane] = []
    rest = sampled(points, rng)
    least = max(3, STRAY * len(rest))
    for _ in range(FALLBACK_PLANES):
        plane = fit_floor(rest, options, rng)
        if plane is None or plane.inliers.sum() < least:
            break
        if plane.offset < 0:  # else a ceiling, or nothing level: the camera is below it
            found.append(plane)
        rest = rest[~plane.inliers]
    return found


def find_floor(
    points: NDArray[np.float64],
    objects: Sequence[NDArray[np.float64]],
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> Plane | None:
    """Without a floor mask: of the level planes in the picture, the one that most objects stand on (a table top, too);
    of equal ones the one with the fewest points below it.

    Args:
        points: (N, 3) of what is no object, camera frame. objects: (N, 3) of each.
        options: thresholds.
        rng: source of RANSAC's hypotheses.
    """
    points = sampled(points, rng)

    def score(plane: Plane) -> tuple[int, float]:
        below = float((points @ plane.normal - plane.offset < -_threshold(points, options)).mean())
        return sum(_stands_on(cloud, plane, options.plane_threshold) for cloud in objects), -below

    return max(level_planes(points, options, rng), key=score, default=None)


def _stands_on(points: NDArray[np.float64], plane: Plane, reach: float) -> bool:
    """Whether the lowest of an object's points (N, 3) are within `reach` of a plane, metres at 1 m."""
    far = max(1.0, float(np.median(points[:, 2])))
    return bool(abs(np.quantile(points @ plane.normal - plane.offset, STRAY)) < reach * far)


def _face_up(plane: Plane | None) -> Plane | None:
    if plane is None or plane.normal @ UP_IN_IMAGE >= 0:
        return plane
    return Plane(-plane.normal, -plane.offset, plane.inliers)


def floor_frame(floor: Plane) -> NDArray[np.float64]:
    """`floor_from_camera` (4, 4): z along the floor's normal, origin below the camera, x along the view."""
    up = floor.normal
    forward = np.array([0.0, 0.0, 1.0])
    x = forward - (forward @ up) * up
    if np.linalg.norm(x) < 1e-3:  # the camera looks straight down: image-up is ahead
        x = UP_IN_IMAGE - (UP_IN_IMAGE @ up) * up
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(up, x), up])
    return rigid(rotation, [0.0, 0.0, -floor.offset])


def fit_wall(
    points: NDArray[np.float64], camera_height: float, options: ExtractionConfig, rng: np.random.Generator
) -> tuple[NDArray[np.float64], float, int] | None:
    """Horizontal normal facing the camera, offset and number of points of one wall.

    Args:
        points: (N, 3) of one wall mask in the floor frame, whose origin is below the camera.
        camera_height: the camera is at (0, 0, camera_height).
        options: thresholds.
        rng: source of RANSAC's hypotheses.
    """
    if len(points) < 3:
        return None
    points = sampled(points, rng)
    threshold = _threshold(points - [0, 0, camera_height], options)
    plane = fit_plane(
        points, threshold, options.ransac_iterations, rng, plausible=lambda normals: np.abs(normals[:, 2]) < WALL_TILT
    )
    if plane is None:
        return None
    normal = plane.normal * [1, 1, 0]
    normal /= np.linalg.norm(normal)
    offset = float(np.median(points[plane.inliers] @ normal))
    if offset > 0:  # the camera, above the origin, is on the side that the normal faces
        normal, offset = -normal, -offset
    return normal, offset, int(plane.inliers.sum())


def find_walls(
    points: NDArray[np.float64],
    free: NDArray[np.bool_],
    camera_height: float,
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> list[tuple[NDArray[np.float64], float, int]]:
    """Walls that have no mask of their own: upright planes behind which nothing is seen, as `fit_wall` has them.

    Args:
        points: (N, 3) of the picture, floor frame.
        free: (N,) which of them may be a wall.
        camera_height: the camera is at (0, 0, camera_height).
        options: thresholds.
        rng: source of RANSAC's hypotheses.
    """
    kept = np.sort(rng.permutation(len(points))[:MAX_POINTS])
    points, rest = points[kept], points[kept[free[kept]]]
    reach, found = _threshold(points - [0, 0, camera_height], options), []
    for _ in range(FALLBACK_PLANES):
        fit = fit_wall(rest, camera_height, options, rng)
        if fit is None or fit[2] < max(3, STRAY * len(points)):
            break
        normal, offset, _ = fit
        near = rest[np.abs(rest @ normal - offset) < reach]
        faces = -offset > GRAZING * float(np.median(np.linalg.norm(near[:, :2], axis=1)))
        if faces and (points @ normal - offset < -2 * reach).mean() < STRAY:
            found.append(fit)
        rest = rest[rest @ normal - offset > reach]
    return found


def merge_walls(
    fits: list[tuple[NDArray[np.float64], float, int]], options: ExtractionConfig
) -> tuple[list[Wall], list[str]]:
    """One wall per plane: parts of the same wall, left and right of a cupboard say, count as one.

    Returns: the walls, and the id of the wall that each fit belongs to.
    """
    merged: list[tuple[NDArray[np.float64], float, int]] = []
    ids = []
    for normal, offset, count in fits:
        for k, (other, other_offset, other_count) in enumerate(merged):
            same_way = normal @ other > np.cos(np.deg2rad(options.wall_merge_angle))
            if same_way and abs(offset - other_offset) < options.wall_merge_distance:
                total = count + other_count
                mean = normal * count + other * other_count
                mean_offset = (offset * count + other_offset * other_count) / total
                merged[k] = (mean / np.linalg.norm(mean), mean_offset, total)
                break
        else:
            k = len(merged)
            merged.append((normal, offset, count))
        ids.append(f"wall_{k + 1}")
    walls = [
        Wall(id=f"wall_{k}", normal=(float(normal[0]), float(normal[1]), 0.0), offset=float(offset), points=count)
        for k, (normal, offset, count) in enumerate(merged, start=1)
    ]
    return walls, ids
