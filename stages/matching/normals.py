"""Surface normals of patches from depth, in a frame that two views of one shape share."""

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.cameras import back_project
from roomkin.stages.geometry.crop import View

NORMAL_COLUMNS = 27  # normals (x, y, z) of 3 x 3 patches
MINIMUM_POINTS = 6  # pixels with depth that make a plane: twice what one needs; chosen
Array = NDArray[np.float64]


def patch_normals(view: View, grid: int) -> NDArray[np.float32]:
    """Unit normals (grid, grid, 3) of a cut view, towards the camera; 0 where depth is missing.

    A patch's normal is that of the plane fitted to the points of the 3 x 3 patches around it: least
    squares averages depth noise out. The axes are those of `object_frame`.
    """
    empty = np.zeros((grid, grid, 3), np.float32)
    if view.depth is None or view.intrinsics is None:
        return empty
    valid = view.mask & (view.depth > 0)
    if valid.sum() < MINIMUM_POINTS:
        return empty
    seen = back_project(view.depth, view.intrinsics)[valid]
    center = np.median(seen, axis=0)
    seen -= center
    scale = float(np.abs(seen).max()) or 1.0
    x, y, z = np.ascontiguousarray((seen / scale).T)
    moments = np.zeros((*valid.shape, 10))
    moments[valid] = np.stack([np.ones(len(x)), x, y, z, x * x, x * y, x * z, y * y, y * z, z * z], axis=-1)
    sums = cv2.blur(_cell_sums(moments, grid), (3, 3), borderType=cv2.BORDER_CONSTANT)

    filled = sums[..., 0] * 9 >= MINIMUM_POINTS
    mean = sums[..., 1:] / np.maximum(sums[..., :1], 1e-12)
    first, second = mean[..., :3], mean[..., [3, 4, 5, 4, 6, 7, 5, 7, 8]].reshape(grid, grid, 3, 3)
    covariance = second - first[..., :, None] * first[..., None, :]
    normals = np.linalg.eigh(covariance)[1][..., 0]
    away = ((first * scale + center) * normals).sum(-1) > 0
    normals = np.where(away[..., None], -normals, normals) @ object_frame(center, view.up)
    return np.where(filled[..., None], normals, 0).astype(np.float32)


def _cell_sums(values: Array, grid: int) -> Array:
    """Sums (grid, grid, C) over the cells of an image (H, W, C)."""
    for axis in (0, 1):
        size = values.shape[axis]
        if size >= grid:
            values = np.add.reduceat(values, np.arange(grid) * size // grid, axis=axis)
        else:  # fewer pixels than cells: repeat them
            values = np.take(values, np.arange(grid) * size // grid, axis=axis)
    return values


def object_frame(center: Array, up: Array | None) -> Array:
    """Axes (3, 3), in columns and in the camera frame, of a frame that looks from the object at the camera.

    With `up`: right, up, and the horizontal direction towards the camera, so that neither the camera's
    tilt nor the object's place in the picture matters. Without: the axis towards the camera is the
    viewing ray, and up is the image's.
    """
    towards = -center / np.linalg.norm(center)
    if up is None or abs(up @ towards) > 0.99:  # seen from straight above, "towards" has no horizontal part
        upwards = np.array([0.0, -1.0, 0.0])
        upwards -= towards * (upwards @ towards)
    else:
        upwards = np.array(up, dtype=float)
        towards = towards - upwards * (towards @ upwards)
    upwards /= np.linalg.norm(upwards)
    towards /= np.linalg.norm(towards)
    return np.column_stack([np.cross(upwards, towards), upwards, towards])


def neighbourhood(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Normals of the 3 x 3 patches around each patch as vectors (grid, grid, 27) of length at most 1."""
    grid = normals.shape[0]
    padded = np.pad(normals, ((1, 1), (1, 1), (0, 0)))
    parts = [padded[y : y + grid, x : x + grid] for y in range(3) for x in range(3)]
    return np.concatenate(parts, axis=-1) / np.float32(3)
