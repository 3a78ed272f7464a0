"""What the pixels of a picture with depth show, as points in space."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stages.geometry.cameras import back_project
from stages.geometry.frames import apply

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class PointMap:
    """A depth image in a frame.

    depth: (H, W) metres along the optical axis, 0: unknown. intrinsics: (3, 3) pixels. frame: `frame_from_camera`
    (4, 4), e.g. `floor_from_camera`; by default points are in the camera's own.
    """

    depth: NDArray[np.floating]
    intrinsics: Array
    frame: Array = field(default_factory=lambda: np.eye(4))

    @cached_property
    def known(self) -> Mask:
        """Pixels (H, W) with depth."""
        return np.asarray(self.depth > 0)

    @cached_property
    def points(self) -> Array:
        """(H, W, 3) of the pixels; NaN where depth is unknown."""
        points = apply(self.frame, back_project(self.depth, self.intrinsics))
        return np.where(self.known[..., None], points, np.nan)

    @property
    def eye(self) -> Array:
        """Where the camera is, (3,)."""
        return np.asarray(self.frame[:3, 3])

    def of(self, mask: Mask) -> Array:
        """Points (N, 3) of the pixels of a mask (H, W), as far as their depth is known."""
        return self.points[mask & self.known]
