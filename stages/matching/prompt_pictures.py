"""Pictures of an object for a judge that looks: the whole picture with a box around it, and the object alone."""

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import ImageColor

from stages.geometry.masks import pixel_bounds
from stages.matching.crop import View, cut

FRAME_GAP = 4  # pixels between the object and its box


def boxed(view: View) -> NDArray[np.uint8]:
    """The picture (H, W, 3) with a red box around the object."""
    x0, y0, x1, y1 = pixel_bounds(view.mask)
    height, width = view.mask.shape
    low, high = (
        (max(0, x0 - FRAME_GAP), max(0, y0 - FRAME_GAP)),
        (min(width, x1 + FRAME_GAP) - 1, min(height, y1 + FRAME_GAP) - 1),
    )
    picture = np.ascontiguousarray(view.rgb).copy()
    cv2.rectangle(picture, low, high, ImageColor.getrgb("red"), max(2, width // 300))
    return picture


def alone(view: View) -> NDArray[np.uint8]:
    """The object's part of the picture, what is not the object darkened."""
    shade = np.where(view.mask[..., None], view.rgb, view.rgb // 3).astype(np.uint8)
    return cut(View(shade, view.mask)).rgb
