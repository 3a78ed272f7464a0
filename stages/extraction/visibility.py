"""A picture with depth in the floor frame, and how far apart things are in it that touch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stages.contracts.objects import USUAL_ERROR, DepthError
from stages.geometry.point_map import PointMap

CONTACT = 0.045  # metres, besides the error of depth: what is less apart touches, and hides nothing; chosen


@dataclass(frozen=True, eq=False)
class DepthView(PointMap):
    """What a picture shows (depth is 0 where it is cropped away), in the floor frame, and how far its depth errs."""

    error: DepthError = USUAL_ERROR

    def distance(self, point: ArrayLike) -> float:
        """Distance in metres from the camera to a point of the floor frame."""
        return float(np.linalg.norm(np.asarray(point, dtype=float) - self.eye))

    def tolerance(self, point: ArrayLike) -> float:
        """Gap in metres that counts as touching at a point of the floor frame."""
        return CONTACT + self.error.predict(self.distance(point))
