"""A picture with its masks numbered, for people and language models."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.contracts.images import color_of


def draw_numbers(rgb: NDArray[np.uint8], masks: Sequence[NDArray[np.bool_]]) -> NDArray[np.uint8]:
    """The picture with masks tinted, each with its number, from 1, where it is widest."""
    shown = rgb.copy()
    for k, mask in enumerate(masks):
        shown[mask] = (0.5 * rgb[mask] + 0.5 * np.array(color_of(k))).astype(np.uint8)
    size = max(0.5, max(rgb.shape) / 500)
    for k, mask in enumerate(masks):
        if not mask.any():  # all of it lies behind others
            continue
        inside = np.pad(mask, 1).astype(np.uint8)
        _, _, _, (x, y) = cv2.minMaxLoc(cv2.distanceTransform(inside, cv2.DIST_L2, 3))
        (width, height), _ = cv2.getTextSize(str(k + 1), cv2.FONT_HERSHEY_SIMPLEX, size, round(3 * size))
        at = (x - 1 - width // 2, y - 1 + height // 2)
        for color, thickness in (((0, 0, 0), 5), ((255, 255, 255), 2)):
            cv2.putText(shown, str(k + 1), at, cv2.FONT_HERSHEY_SIMPLEX, size, color, round(thickness * size))
    return shown
