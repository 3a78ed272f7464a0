"""Yaw of an asset in the floor frame and as the camera sees it."""

import numpy as np
from numpy.typing import ArrayLike

from roomkin.stages.geometry.frames import wrap_angle


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
