"""Which pixels are trusted: the central crop and mask erosion (paper A.7)."""

import cv2
import numpy as np
from numpy.typing import NDArray

OUTLINE = 3  # pixels by which the outline of a mask may be off
SPECK = 0.01  # parts of a mask with a smaller share of its pixels are specks


def central_crop(shape: tuple[int, int], share: float) -> NDArray[np.bool_]:
    """Mask (H, W) of the central `share` of the image in either direction."""
    inside = np.zeros(shape, dtype=bool)
    v, u = (round(length * (1 - share) / 2) for length in shape)
    inside[v : shape[0] - v, u : shape[1] - u] = True
    return inside


def without_specks(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The mask without its tiny separate parts."""
    _, parts, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] >= SPECK * mask.sum()
    large[0] = False
    return large[parts]


def eroded(mask: NDArray[np.bool_], radius: int, keep: float) -> NDArray[np.bool_]:
    """Take up to `radius` pixels off the border, fewer if less than `keep` of the mask would remain."""
    for size in range(radius, 0, -1):
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * size + 1, 2 * size + 1))
        smaller = cv2.erode(mask.astype(np.uint8), kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
        if smaller.sum() >= keep * mask.sum():
            return smaller
    return mask
