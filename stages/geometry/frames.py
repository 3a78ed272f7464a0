"""Rotations, rigid transforms (4x4 `target_from_source`), and the pinhole camera: x right, y down, z forward."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
ROUNDING = 1e-9  # relative: a smaller number is an error of sums, and differs from processor to processor
SAMPLED = 3000  # points or pixels that stand for all others where each costs time; chosen for time
# z up -> y up (glTF); and the axes of a level camera that looks along y (x right, y down, z forward) -> z up.
Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])

# Smallest turn about z that maps an object onto itself, by `Asset.symmetry`.
SYMMETRY_PERIOD = {
    "none": 2 * np.pi,
    "half_turn": np.pi,
    "third_turn": 2 * np.pi / 3,
    "quarter_turn": np.pi / 2,
    "full": 0.0,
}


def round_vector(vector: ArrayLike) -> tuple[float, float, float]:
    """A 3-vector as it is written to files: micrometres."""
    x, y, z = (round(float(value), 6) for value in np.asarray(vector))
    return x, y, z


def wrap_angle(angle: float, period: float = 2 * np.pi) -> float:
    """`angle` modulo `period`, in (-period / 2, period / 2]."""
    return float(period / 2 - (period / 2 - angle) % period)


def angle_difference(a: float, b: float, symmetry: str = "none") -> float:
    """Smallest turn between two yaws in [0, pi], given the object's rotational symmetry about z."""
    period = SYMMETRY_PERIOD[symmetry]
    return abs(wrap_angle(a - b, period)) if period else 0.0


def yaw_matrix(yaw: float) -> NDArray[np.float64]:
    """3x3 rotation about z."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def yaw_of_matrix(rotation: ArrayLike) -> float:
    """Yaw of the rotated x axis; the rotation is taken to be about z."""
    rotation = np.asarray(rotation)
    return float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def yaw_quaternion(yaw: float) -> NDArray[np.float64]:
    """Quaternion wxyz of a rotation about z."""
    return np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])


def quaternion_from_matrix(rotation: ArrayLike) -> NDArray[np.float64]:
    """Unit quaternion wxyz, w >= 0, of a 3x3 rotation."""
    return Rotation.from_matrix(np.asarray(rotation)).as_quat(canonical=True, scalar_first=True)


def make_transform(rotation: ArrayLike, translation: ArrayLike) -> NDArray[np.float64]:
    """4x4 transform of a 3x3 rotation and a translation."""
    transform = np.eye(4)
    transform[:3, :3] = rotation
    transform[:3, 3] = translation
    return transform


def invert_transform(transform: ArrayLike) -> NDArray[np.float64]:
    """Inverse of a rigid 4x4 transform."""
    transform = np.asarray(transform, dtype=float)
    rotation = transform[:3, :3].T
    return make_transform(rotation, -rotation @ transform[:3, 3])


def transform_points(transform: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
    """Transform points (..., 3)."""
    transform = np.asarray(transform, dtype=float)
    return np.asarray(points) @ transform[:3, :3].T + transform[:3, 3]


def rotation_of(yaw: float, pitch: float, roll: float) -> Array:
    """room_from_camera (3, 3): turned by `yaw` to the left, tilted up by `pitch`, then rolled clockwise (radians)."""
    c, s = np.cos([pitch, roll]), np.sin([pitch, roll])
    tilt = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    turn = np.array([[c[1], -s[1], 0], [s[1], c[1], 0], [0, 0, 1]])
    return yaw_matrix(yaw) @ Y_UP[:3, :3] @ tilt @ turn


OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])  # OpenGL's camera axes (x right, y up, z backward) from OpenCV's, and back
# OpenCV's camera axes -> SAPIEN's (x forward, y left, z up)
SAPIEN_FROM_OPENCV = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
JUST_BEFORE = 0.01  # metres from a camera: what lies behind it is shown there; chosen
MARGIN = 0.06  # share of a picture left free around what it frames; chosen


def intrinsics_from_fov(width: int, height: int, fov_y: float) -> NDArray[np.float64]:
    """3x3 matrix K for a vertical field of view in radians; square pixels, pixel centers at integers."""
    focal = height / 2 / np.tan(fov_y / 2)
    return make_intrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2)


def make_intrinsics(fx: float, fy: float, cx: float, cy: float) -> NDArray[np.float64]:
    """K (3, 3), pixels."""
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def scale_intrinsics(intrinsics: NDArray[np.float64], width: float, height: float) -> NDArray[np.float64]:
    """K of the picture scaled by the factors `width` and `height`; pixel centers are at integer coordinates."""
    (fx, _, cx), (_, fy, cy), _ = intrinsics
    return make_intrinsics(fx * width, fy * height, (cx + 0.5) * width - 0.5, (cy + 0.5) * height - 0.5)


def look_at(eye: ArrayLike, target: ArrayLike) -> NDArray[np.float64]:
    """4x4 `world_from_camera` of a level camera at `eye` that looks at `target`; world z is up."""
    eye = np.asarray(eye, dtype=float)
    forward = np.asarray(target, dtype=float) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return make_transform(np.column_stack([right, np.cross(forward, right), forward]), eye)


@dataclass(frozen=True)
class FloorCamera:
    """A camera in the floor frame: its pose (4, 4), OpenCV axes, and K (3, 3), pixels."""

    floor_from_camera: NDArray[np.float64]
    intrinsics: NDArray[np.float64]

    @property
    def eye(self) -> NDArray[np.float64]:
        """Its position (3,)."""
        return self.floor_from_camera[:3, 3]

    @cached_property
    def camera_from_floor(self) -> NDArray[np.float64]:
        """Its pose, inverted."""
        return invert_transform(self.floor_from_camera)

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels (N, 2) of points (N, 3), floor frame; those behind it as just before it."""
        in_camera = transform_points(self.camera_from_floor, points)
        in_camera[:, 2] = np.maximum(in_camera[:, 2], JUST_BEFORE)
        return project(in_camera, self.intrinsics)


def back_project(depth: NDArray[np.floating], intrinsics: ArrayLike) -> NDArray[np.float64]:
    """Points (H, W, 3) in the camera frame of a depth image (H, W) in metres along the optical axis."""
    height, width = depth.shape
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(np.asarray(intrinsics, dtype=float)).T
    return rays * depth[..., None]


def project(points: ArrayLike, intrinsics: ArrayLike) -> NDArray[np.float64]:
    """Pixels (..., 2) of points (..., 3) in the camera frame; NaN behind the camera."""
    image = np.asarray(points, dtype=float) @ np.asarray(intrinsics, dtype=float).T
    depth = np.where(image[..., 2:] > 1e-6, image[..., 2:], np.nan)
    return image[..., :2] / depth


@dataclass(frozen=True, eq=False)
class PointMap:
    """A depth image in a frame.

    depth: (H, W) metres along the optical axis, 0: unknown. intrinsics: (3, 3) pixels. frame: `frame_from_camera`
    (4, 4), e.g. `floor_from_camera`; by default points are in the camera's own.
    """

    depth: NDArray[np.floating]
    intrinsics: NDArray[np.float64]
    frame: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))

    @cached_property
    def known(self) -> NDArray[np.bool_]:
        """Pixels (H, W) with depth."""
        return np.asarray(self.depth > 0)

    @cached_property
    def points(self) -> NDArray[np.float64]:
        """(H, W, 3) of the pixels; NaN where depth is unknown."""
        known = self.known[..., None]
        return np.where(known, transform_points(self.frame, back_project(self.depth, self.intrinsics)), np.nan)

    def of(self, mask: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Points (N, 3) of the pixels of a mask (H, W), as far as their depth is known."""
        known = mask & self.known
        return self.points[known]


def view_yaw(camera: ArrayLike, center: ArrayLike, psi: float) -> float:
    """Yaw in the floor frame of an asset that looks to the camera as it does at snapshot yaw `psi`.

    At psi = 0 the asset's front (+x) faces the camera; the direction is that to the object, not the
    optical axis, so that things at the border of the picture are turned rightly as well.
    """
    away = np.asarray(center, dtype=float)[:2] - np.asarray(camera, dtype=float)[:2]
    return wrap_angle(float(np.arctan2(-away[1], -away[0])) + psi)


def view_angle(camera: ArrayLike, center: ArrayLike, yaw: float) -> float:
    """Snapshot yaw psi at which an asset of this yaw in the floor frame is seen; the inverse of `view_yaw`."""
    return wrap_angle(yaw - view_yaw(camera, center, 0.0))
