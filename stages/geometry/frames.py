"""Rotations and rigid transforms: yaw, quaternions (wxyz), 4x4 matrices `target_from_source`."""

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
