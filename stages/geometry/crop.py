"""One object in one picture, and its crop: what every patch encoder starts from."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.masks import pixel_bounds

GREY = 127  # color of what is masked out


@dataclass(frozen=True)
class View:
    """An object as a camera sees it.

    rgb (H, W, 3) uint8; mask (H, W) bool, the object's visible pixels; depth (H, W) float32 metres along
    the optical axis, 0: unknown, or None; intrinsics (3, 3) in pixels; up (3,) the unit vector against
    gravity in the camera frame, or None where it is not known.
    """

    rgb: NDArray[np.uint8]
    mask: NDArray[np.bool_]
    depth: NDArray[np.float32] | None = None
    intrinsics: NDArray[np.float64] | None = None
    up: NDArray[np.float64] | None = None


def cut(view: View) -> View:
    """The view cut to the box of its mask; the principal point moves along, everything else stays as it is."""
    x0, y0, x1, y1 = pixel_bounds(view.mask)
    window = np.s_[y0:y1, x0:x1]
    intrinsics = None
    if view.intrinsics is not None:
        intrinsics = np.array(view.intrinsics, dtype=float)
        intrinsics[0, 2] -= x0
        intrinsics[1, 2] -= y0
    depth = None if view.depth is None else view.depth[window]
    return View(view.rgb[window], view.mask[window], depth, intrinsics, view.up)


def darken_rest(view: View) -> NDArray[np.uint8]:
    """The object's part of the picture, what is not the object darkened."""
    shade = np.where(view.mask[..., None], view.rgb, view.rgb // 3).astype(np.uint8)
    return cut(View(shade, view.mask)).rgb


def masked_square(view: View, width: int, height: int) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """A cut view as a picture (height, width, 3), grey outside the mask, and the mask's coverage (height, width).

    The aspect ratio is not kept: cousins are rescaled per axis, so it says little about the model.
    """
    rgb = np.where(view.mask[..., None], view.rgb, np.uint8(GREY))
    shrinks = view.mask.shape[0] > height or view.mask.shape[1] > width
    method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    coverage = cv2.resize(view.mask.astype(np.float32), (width, height), interpolation=method)
    picture = cv2.resize(rgb, (width, height), interpolation=method)
    return picture.astype(np.uint8, copy=False), coverage.astype(np.float32, copy=False)


def patch_positions(rows: int, columns: int) -> NDArray[np.float32]:
    """Centers (rows, columns, 2) of the patches as (x, y) in [-1, 1] of the crop."""
    y = (np.arange(rows) + 0.5) / rows * 2 - 1
    x = (np.arange(columns) + 0.5) / columns * 2 - 1
    return np.stack(np.meshgrid(x, y), axis=-1).astype(np.float32)


def foreground(coverage: NDArray[np.float32], rows: int, columns: int, least: float = 0.5) -> NDArray[np.bool_]:
    """Patches (rows, columns) that the mask covers by a share of `least`; if there are none, those it touches."""
    share = cv2.resize(coverage, (columns, rows), interpolation=cv2.INTER_AREA)
    return share >= least if (share >= least).any() else share > 0
