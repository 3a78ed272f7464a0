"""Extrapolate depth from the eroded part of a mask to its border.

Estimated depth is wrong along outlines, so masks are eroded (paper A.7). But without their border
objects come out too small: two pixels are 1 cm at 3 m on a face seen straight on, and 10 cm on a
table top seen at a low angle. Inverse depth is linear in the pixel on any plane, so it is continued
from the core by local linear fits.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.geometry.frames import Array
from stages.geometry.masks import OUTLINE, Mask

RIDGE = 0.1  # pixels squared, added to the variances of a fit: a core one pixel wide has none across it; chosen
BLUR_BLOCK = 32  # pixels that OpenCV blurs at once
MAX_CHANGE = 0.05  # largest relative change of depth from the core's local mean; chosen


def _blur(values: Array) -> Array:
    """Local means; the standard deviation of the weights is as wide as a border."""
    return np.asarray(cv2.GaussianBlur(values, (0, 0), OUTLINE, borderType=cv2.BORDER_CONSTANT), dtype=np.float64)


def continue_depth(depth: NDArray[np.floating], core: Mask, border: Mask) -> Array:
    """Depth (H, W): the given one on `core`, continued on `border` where the core is near, 0 elsewhere.

    Args:
        depth: (H, W) metres; 0 where unknown.
        core: pixels with trusted depth.
        border: pixels whose depth is to be found.
    """
    continued = np.zeros(depth.shape)
    rows, columns = np.nonzero(core | border)
    if len(rows):
        reach = int(5 * OUTLINE) + 1  # of the weights
        # Whole blocks of pixels, which the processor takes together: the same bits as in the whole picture.
        ends = (
            (max(0, at.min() - reach) // BLUR_BLOCK, (at.max() + reach) // BLUR_BLOCK + 1) for at in (rows, columns)
        )
        window = tuple(slice(BLUR_BLOCK * first, BLUR_BLOCK * last) for first, last in ends)
        height, width = depth.shape
        v, u = np.meshgrid(np.arange(height) - height / 2, np.arange(width) - width / 2, indexing="ij")
        continued[window] = _extrapolate(depth[window], core[window], border[window], u[window], v[window])
    return continued


def _extrapolate(depth: NDArray[np.floating], core: Mask, border: Mask, u: Array, v: Array) -> Array:
    """The same in the part of the picture that holds core and border; u and v are its pixels."""
    known = core & (depth > 0)
    weight = known.astype(np.float64)
    inverse = np.where(known, 1 / np.maximum(depth, 1e-6), 0.0)
    total = np.maximum(_blur(weight), 1e-12)
    mean_u, mean_v, mean = (_blur(weight * field) / total for field in (u, v, inverse))
    var_u = _blur(weight * u * u) / total - mean_u**2 + RIDGE
    var_v = _blur(weight * v * v) / total - mean_v**2 + RIDGE
    cov_uv = _blur(weight * u * v) / total - mean_u * mean_v
    cov_u = _blur(u * inverse) / total - mean_u * mean
    cov_v = _blur(v * inverse) / total - mean_v * mean
    determinant = var_u * var_v - cov_uv**2
    slope_u = (var_v * cov_u - cov_uv * cov_v) / determinant
    slope_v = (var_u * cov_v - cov_uv * cov_u) / determinant
    fitted = mean + slope_u * (u - mean_u) + slope_v * (v - mean_v)
    fitted = np.clip(fitted, mean * (1 - MAX_CHANGE), mean * (1 + MAX_CHANGE))
    near = border & ~known & (total > 1e-3)
    return np.where(known, depth, np.where(near, 1 / np.maximum(fitted, 1e-6), 0.0))
