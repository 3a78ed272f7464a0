"""What an encoder without a network sees of patches: mean colors in CIELAB, and surface normals from depth."""

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import back_project
from roomkin.stages.geometry.masks import ObjectView, cut

UNIT = 30  # a difference in Lab that counts as 1: a shade darker or another hue, well above noise; chosen
LIGHTNESS = 0.5  # of the weight of a and b: light changes it first; chosen
CELLS = 16  # the crop is averaged over so many cells a side; chosen


def patch_colors(view: ObjectView, positions: NDArray[np.float32]) -> NDArray[np.float32]:
    """Lab color (P, 3), in units of `UNIT`, of the object around each of its patches.

    `positions` (P, 2) are x, y in [-1, 1] of the crop. Only the object's pixels count; what lies beside its mask
    does not.
    """
    if not len(positions):
        return np.empty((0, 3), np.float32)
    view = cut(view)
    lab = cv2.cvtColor(view.rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    seen = view.mask.astype(np.float32)[..., None]
    method = cv2.INTER_AREA if min(view.mask.shape) > CELLS else cv2.INTER_LINEAR
    cells = cv2.resize(np.concatenate([lab * seen, seen], axis=-1), (CELLS, CELLS), interpolation=method)
    wide = cv2.blur(cells, (3, 3))  # for cells that the mask hardly touches
    sums = np.where(cells[..., 3:] > 0.05, cells, wide)
    colors = sums[..., :3] / np.maximum(sums[..., 3:], 1e-3)
    column, row = np.clip(((positions.T + 1) / 2 * CELLS).astype(int), 0, CELLS - 1)
    return (colors[row, column] / UNIT).astype(np.float32)


def color_weights(color: float) -> NDArray[np.float32]:
    """Factors (3,) on the color columns."""
    return np.array([LIGHTNESS, 1, 1], np.float32) * np.float32(color)


NORMAL_COLUMNS = 27  # normals (x, y, z) of 3 x 3 patches
MINIMUM_POINTS = 6  # pixels with depth that make a plane: twice what one needs; chosen
Array = NDArray[np.float64]


def patch_normals(view: ObjectView, grid: int) -> NDArray[np.float32]:
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
