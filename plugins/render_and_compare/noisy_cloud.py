"""The ends of an object from the noisy cloud that a depth camera has of it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import yaw_matrix

MAX_INSET = 0.25  # share of the length that is taken off an end at most; chosen
Array = NDArray[np.float64]


@dataclass(frozen=True)
class NoisyCloud:
    """An object as a depth camera sees it.

    points: (N, 3). camera: its position (3,), in the same frame, z up. error: the standard deviation of depth, metres,
    at a distance from the camera, metres.
    """

    points: Array
    camera: Array
    error: Callable[[float], float]

    @cached_property
    def ray(self) -> Array:
        """Unit vector (3,) from the camera to the middle of the points."""
        ray = self.points.mean(axis=0) - self.camera
        return np.asarray(ray / np.linalg.norm(ray))

    @cached_property
    def noise(self) -> float:
        """Standard deviation, metres, of the points along the ray, caused by depth noise."""
        return self.error(float(np.linalg.norm(self.points.mean(axis=0) - self.camera)))

    def measure_ends(self, yaw: float, trim: float, deviations: float) -> Array:
        """Lowest and highest level coordinates (2, 2) of the points along axes turned by `yaw`.

        Noise puts points outside the faces, so `deviations` standard deviations are taken off at both ends.

        Args:
            trim: share of the points left out at each end.
        """
        limits = np.quantile(self.points[:, :2] @ yaw_matrix(yaw)[:2, :2], [trim, 1 - trim], axis=0)
        inset = np.minimum(deviations * self.noise_along(yaw), MAX_INSET * (limits[1] - limits[0]))
        return np.stack([limits[0] + inset, limits[1] - inset])

    def noise_along(self, yaw: float) -> Array:
        """Standard deviation (2,), metres, of noise along the level axes turned by `yaw`."""
        return np.abs(self.ray[:2] @ yaw_matrix(yaw)[:2, :2]) * self.noise
