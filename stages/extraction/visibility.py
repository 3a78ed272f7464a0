"""Visibility of points in space by the depth image: seen to be empty, or hidden."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stages.contracts.objects import USUAL_ERROR, DepthError
from stages.geometry.cameras import project
from stages.geometry.frames import Array, apply, inverse
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

    def pixel_size(self, distance: float) -> float:
        """Size in metres of a pixel's footprint at a distance."""
        return distance / float(self.intrinsics[0, 0])

    def intersect_level(self, columns: NDArray[np.integer], rows: NDArray[np.integer], height: float) -> Array:
        """Where the rays through pixels (N,), (N,) meet the plane z = `height` of the floor frame: (N, 3), else NaN."""
        pixels = np.stack([columns, rows, np.ones_like(rows)], axis=1).astype(np.float64)
        rays = pixels @ np.linalg.inv(self.intrinsics).T @ self.frame[:3, :3].T
        down = np.where(rays[:, 2] < 0, rays[:, 2], np.nan)
        return self.eye + rays * ((height - self.eye[2]) / down)[:, None]

    def free_share(self, points: Array, own: NDArray[np.bool_]) -> float:
        """Share of the points (N, 3), floor frame, that an object with the mask `own` (H, W) does not fill.

        Were the point part of the object, its pixel would show the object, or something nearer that
        hides it. A pixel that shows neither tells that the point is empty. 0 if no point is in the picture.
        """
        in_camera = apply(inverse(self.frame), points)
        pixels = project(in_camera, self.intrinsics)
        height, width = self.depth.shape
        columns, rows = np.rint(np.where(np.isfinite(pixels), pixels, -1)).astype(int).T
        inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        columns, rows, z = columns[inside], rows[inside], in_camera[inside, 2]
        shown = self.depth[rows, columns]
        hidden = own[rows, columns] | (shown < z - CONTACT - self.error.a - self.error.b * z**2)
        return float((~hidden[shown > 0]).mean()) if (shown > 0).any() else 0.0


def cell_centres(low: Array, high: Array, counts: tuple[int, ...]) -> Array:
    """Cell centres (N, d) of a regular grid between two corners (d,)."""
    axes = [lo + (np.arange(n) + 0.5) / n * (hi - lo) for lo, hi, n in zip(low, high, counts, strict=True)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
