"""Mean color of patches, in CIELAB: stored beside every encoder's features, compared if `colour` gives it a weight."""

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.crop import View, cut

UNIT = 30  # a difference in Lab that counts as 1: a shade darker or another hue, well above noise; chosen
LIGHTNESS = 0.5  # of the weight of a and b: light changes it first; chosen
CELLS = 16  # the crop is averaged over so many cells a side; chosen


def patch_colors(view: View, positions: NDArray[np.float32]) -> NDArray[np.float32]:
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
