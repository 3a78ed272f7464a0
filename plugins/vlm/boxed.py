"""A picture that shows a language model which thing is meant."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray


def draw_box(rgb: NDArray[np.uint8], box: Sequence[float]) -> NDArray[np.uint8]:
    """The picture (H, W, 3) with a red box (x0, y0, x1, y1), as far as it lies in the picture."""
    shown = rgb.copy()
    height, width = rgb.shape[:2]
    x0, y0, x1, y1 = np.clip(np.rint(box).astype(int), 0, [width - 1, height - 1] * 2).tolist()
    cv2.rectangle(shown, (x0, y0), (x1, y1), (255, 0, 0), max(2, round(max(rgb.shape) / 300)))
    return shown
