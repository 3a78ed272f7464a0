"""Visibility of points in space by the depth image: seen to be empty, or hidden."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stages.contracts.objects import DepthError
from stages.geometry.cameras import project
from stages.geometry.frames import Array, apply, inverse

CONTACT = 0.045  # metres, besides the error of depth: what is less apart touches, and hides nothing; chosen


def tolerance_of(error: DepthError, distance: float) -> float:
    """Gap in metres that counts as touching at a distance from the camera, metres."""
    return CONTACT + error.predict(distance)


@dataclass(frozen=True)
class DepthView:
    """The depth image (H, W; 0 unknown or cropped away), its camera in the floor frame, and how far it errs."""

    depth: NDArray[np.float32]
    intrinsics: Array
    floor_from_camera: Array
    error: DepthError

    def distance(self, point: ArrayLike) -> float:
        """Distance in metres from the camera to a point of the floor frame."""
        return float(np.linalg.norm(np.asarray(point, dtype=float) - self.floor_from_camera[:3, 3]))

    def tolerance(self, point: ArrayLike) -> float:
        """Gap in metres that counts as touching at a point of the floor frame."""
        return tolerance_of(self.error, self.distance(point))

    def pixel_size(self, distance: float) -> float:
        """Size in metres of a pixel's footprint at a distance."""
        return distance / float(self.intrinsics[0, 0])

    def intersect_level(self, columns: NDArray[np.integer], rows: NDArray[np.integer], height: float) -> Array:
        """Where the rays through pixels (N,), (N,) meet the plane z = `height` of the floor frame: (N, 3), else NaN."""
        pixels = np.stack([columns, rows, np.ones_like(rows)], axis=1).astype(np.float64)
        rays = pixels @ np.linalg.inv(self.intrinsics).T @ self.floor_from_camera[:3, :3].T
        origin = self.floor_from_camera[:3, 3]
        down = np.where(rays[:, 2] < 0, rays[:, 2], np.nan)
        return origin + rays * ((height - origin[2]) / down)[:, None]

    def points(self, columns: NDArray[np.integer], rows: NDArray[np.integer]) -> Array:
        """What pixels (N,), (N,) show, as points (N, 3) of the floor frame; NaN where depth is unknown."""
        rays = np.stack([columns, rows, np.ones_like(rows)], axis=1) @ np.linalg.inv(self.intrinsics).T
        depth = self.depth[rows, columns].astype(np.float64)
        return np.asarray(apply(self.floor_from_camera, rays * np.where(depth > 0, depth, np.nan)[:, None]))

    def free_share(self, points: Array, own: NDArray[np.bool_]) -> float:
        """Share of the points (N, 3), floor frame, that an object with the mask `own` (H, W) does not fill.

        Were the point part of the object, its pixel would show the object, or something nearer that
        hides it. A pixel that shows neither tells that the point is empty. 0 if no point is in the picture.
        """
        in_camera = apply(inverse(self.floor_from_camera), points)
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
