"""Place the camera at the least distance from which it sees all objects."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from roomkin.plugins.scenes.recipe import CameraStand
from roomkin.stages.geometry.cameras import intrinsics_from_fov, look_at, project
from roomkin.stages.geometry.frames import invert_transform, transform_points

Matrix = NDArray[np.float64]


def _aim_camera(eye: Matrix, points: Matrix, intrinsics: Matrix) -> Matrix:
    """`world_from_camera` at `eye` that has the points' picture in its center."""
    target = points.mean(axis=0)
    for _ in range(8):
        world_from_camera = look_at(eye, target)
        pixels = project(transform_points(invert_transform(world_from_camera), points), intrinsics)
        if not np.isfinite(pixels).all():
            break
        middle = (pixels.min(axis=0) + pixels.max(axis=0)) / 2
        ray = np.linalg.inv(intrinsics) @ [*middle, 1.0]
        target = eye + world_from_camera[:3, :3] @ ray
        if np.abs(middle - intrinsics[:2, 2]).max() < 0.1:
            break
    return world_from_camera


def frame(points: Matrix, stand: CameraStand, width: int, height: int, margin: float) -> tuple[Matrix, Matrix]:
    """Intrinsics (3, 3) and `world_from_camera` (4, 4) of the nearest place on the stand's line that shows all points.

    Args:
        points: (N, 3) in the room frame, all of which are to be in the picture.
        stand: direction, eye height and vertical field of view.
        width: of the picture in pixels.
        height: of the picture in pixels.
        margin: share of the picture left free at each border.
    """
    intrinsics = intrinsics_from_fov(width, height, np.deg2rad(stand.fov))
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    azimuth = np.deg2rad(stand.azimuth)
    line = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])

    def pose(distance: float) -> Matrix:
        return _aim_camera(np.array([middle[0], middle[1], stand.height]) + distance * line, points, intrinsics)

    def measure_excess(distance: float) -> float:
        """By how much of the picture's size the points stick out of the margins."""
        pixels = project(transform_points(invert_transform(pose(distance)), points), intrinsics)
        if not np.isfinite(pixels).all():
            return 10.0
        size = np.array([width - 1, height - 1])
        return float(np.abs(pixels / size - 0.5).max() - (0.5 - margin))

    return intrinsics, pose(float(brentq(measure_excess, a=1.0, b=30.0, xtol=1e-4)))
