"""Which patch of a snapshot shows what a patch of another picture of the model shows; and what hides some of it."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.patchnet.network import GRID, SIZE
from stages.geometry.frames import apply
from stages.geometry.masks import MIN_PIXELS, pixel_bounds
from stages.matching.crop import View, cut, foreground, masked_square

Array = NDArray[np.float64]
Rng = np.random.Generator

NEAR = 0.025  # largest distance between the two surfaces, in the model's largest extents
NONE = -1
LEAST_SEEN = 0.5  # share of a model that something may leave


def crop(view: View) -> NDArray[np.uint8]:
    """(SIZE, SIZE, 4) uint8: the crop that encoders see, grey outside the mask, and the mask's coverage."""
    picture, coverage = masked_square(cut(view), SIZE, SIZE)
    return np.dstack([picture, np.round(coverage * 255).astype(np.uint8)])


def centres(view: View) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns (GRID * GRID,) of the pixels in the middle of the patches of a view's crop."""
    x0, y0, x1, y1 = pixel_bounds(view.mask)
    steps = (np.arange(GRID) + 0.5) / GRID
    rows, columns = (y0 + steps * (y1 - y0)).astype(int), (x0 + steps * (x1 - x0)).astype(int)
    grid = np.meshgrid(rows, columns, indexing="ij")
    return grid[0].ravel(), grid[1].ravel()


def matches(view: View, object_from_camera: Array, other: View, camera_from_object: Array) -> NDArray[np.int16]:
    """For every patch of `view` the patch (GRID * GRID,) of `other` that shows the same point of the model, or NONE.

    Both views need depth and intrinsics; the maps are affine, of the same object frame.
    """
    assert view.depth is not None and view.intrinsics is not None
    assert other.depth is not None and other.intrinsics is not None
    rows, columns = centres(view)
    depth = view.depth[rows, columns].astype(float)
    rays = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ np.linalg.inv(view.intrinsics).T
    points = apply(camera_from_object @ object_from_camera, rays * depth[:, None])
    image = points @ np.asarray(other.intrinsics).T
    pixels = np.rint(image[:, :2] / np.maximum(image[:, 2:], 1e-6)).astype(int)
    x0, y0, x1, y1 = pixel_bounds(other.mask)
    u, v = np.clip(pixels[:, 0], x0, x1 - 1), np.clip(pixels[:, 1], y0, y1 - 1)
    seen = (view.mask[rows, columns]) & (depth > 0) & (pixels == np.stack([u, v], axis=-1)).all(axis=1)
    seen &= other.mask[v, u] & (np.abs(other.depth[v, u] - points[:, 2]) < NEAR)
    patch = ((v - y0) * GRID // (y1 - y0)) * GRID + (u - x0) * GRID // (x1 - x0)
    seen &= foreground_of(view)
    return np.where(seen & foreground_of(other)[patch], patch, NONE).astype(np.int16)


def foreground_of(view: View) -> NDArray[np.bool_]:
    """Patches (GRID * GRID,) of the view's crop that encoders look at."""
    return foreground(masked_square(cut(view), SIZE, SIZE)[1], GRID, GRID).ravel()


def hide_part(view: View, rng: Rng) -> View:
    """The view behind something: a side cut off, or a box or an ellipse before it; at least half stays to be seen."""
    x0, y0, x1, y1 = pixel_bounds(view.mask)
    height, width = view.mask.shape
    v, u = np.mgrid[:height, :width]
    for _ in range(4):
        kind = int(rng.integers(3))
        if kind == 0:  # the edge of the picture or of a table: a line across
            angle, share = rng.choice([0, 0.5, 1, 1.5]) * np.pi + rng.normal(0, 0.1), rng.uniform(0.05, 0.4)
            along = np.cos(angle) * (u - x0) / (x1 - x0) + np.sin(angle) * (v - y0) / (y1 - y0)
            mask = view.mask & (along < np.quantile(along[view.mask], 1 - share))
        else:
            centre = rng.uniform([x0, y0], [x1, y1])
            half = rng.uniform(0.08, 0.35, 2) * [x1 - x0, y1 - y0]
            gap = np.abs(np.stack([(u - centre[0]) / half[0], (v - centre[1]) / half[1]]))
            mask = view.mask & ((gap.max(0) if kind == 1 else (gap**2).sum(0)) > 1)
        if mask.sum() >= max(LEAST_SEEN * view.mask.sum(), MIN_PIXELS):
            return replace(view, mask=mask)
    return view


def blemish_picture(rgb: NDArray[np.uint8], rng: Rng) -> NDArray[np.uint8]:
    """The picture with another exposure and gamma, a little blur now and then, and noise."""
    image: NDArray[np.floating] = rgb.astype(np.float32) / 255
    image = np.clip(image * rng.uniform(0.75, 1.25), 0, 1) ** rng.uniform(0.7, 1.4)
    if rng.random() < 0.4:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), float(rng.uniform(0.4, 1.2))), np.float32)
    image += rng.normal(0, rng.uniform(0, 0.03), image.shape).astype(np.float32)
    return (np.clip(image, 0, 1) * 255).round().astype(np.uint8)
