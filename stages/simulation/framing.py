"""The nearest camera position from which everything is in the picture."""

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import MARGIN, make_transform

Array = NDArray[np.float64]

FIELD_OF_VIEW = 0.7  # radians, across


def intrinsics_of(width: int, height: int) -> Array:
    """Intrinsics (3, 3), pixels, of a picture of that size."""
    focal = width / 2 / np.tan(FIELD_OF_VIEW / 2)
    return np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])


def frame_all(points: Array, direction: Array, aspect: float) -> Array:
    """(4, 4) world_from_camera, OpenCV axes: looks against `direction`, as near as all points (N, 3) stay in the frame.

    A point is in the frame if its offsets from the axis stay below its depth times the tangents of the half angles;
    for one viewing direction that is linear in the camera's place, so the nearest place is found directly.

    Args:
        aspect: height by width of the picture.
    """
    forward = -direction / np.linalg.norm(direction)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    tangent = np.tan(FIELD_OF_VIEW / 2) / (1 + MARGIN)
    place = np.zeros(3)
    needed = []
    depth = points @ forward
    for axis, limit in ((right, tangent), (down, tangent * aspect)):
        offset = points @ axis
        high, low = (offset - limit * depth).max(), (offset + limit * depth).min()
        place += axis * (high + low) / 2
        needed.append((high - low) / (2 * limit))
    return make_transform(np.stack([right, down, forward], axis=1), place - max(needed) * forward)
