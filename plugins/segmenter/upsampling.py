"""Labels of a small picture at the size of the whole one: joint bilateral upsampling (Kopf et al. 2007)."""

from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

SPREAD = 0.7  # standard deviation in pixels of the small picture; chosen
DEPTH = 0.02  # and of depth, as a share of it; chosen
COLOUR = 35.0  # and of colour, of 255; chosen
FAR = 20.0  # squared deviations that count at most, so that no pixel stays without a label


def upsample_labels(
    labels: NDArray[np.uint16], depth: NDArray[np.float32], rgb: NDArray[np.uint8]
) -> NDArray[np.uint16]:
    """The label (H, W) that most of the nine small pixels around a pixel have, weighed by how alike they are.

    Args:
        labels: (h, w) of the small picture.
        depth: (H, W) metres, 0: unknown.
        rgb: (H, W, 3).
    """
    shape, small = depth.shape, labels.shape
    places = [(np.arange(size) + 0.5) * count / size - 0.5 for size, count in zip(shape, small, strict=True)]
    small_depth = cv2.resize(depth, small[::-1], interpolation=cv2.INTER_NEAREST)
    colour = rgb.astype(np.float32)
    small_colour = cv2.resize(colour, small[::-1], interpolation=cv2.INTER_AREA)
    shown, weights = [], []
    for steps in product((-1, 0, 1), repeat=2):
        row, column = (
            np.clip(np.rint(place).astype(int) + step, 0, count - 1)
            for place, step, count in zip(places, steps, small, strict=True)
        )
        at = np.ix_(row, column)
        away = ((row - places[0]) ** 2)[:, None] + ((column - places[1]) ** 2)[None]
        further = (small_depth[at] - depth) / np.maximum(depth, 1e-3) / DEPTH
        further = np.where((small_depth[at] > 0) & (depth > 0), further, 1.0)
        unlike = ((small_colour[at] - colour) ** 2).sum(axis=-1) / COLOUR**2
        far = away / SPREAD**2 + np.minimum(further**2, FAR) + np.minimum(unlike, FAR)
        shown.append(labels[at])
        weights.append(np.exp(-far / 2).astype(np.float32))
    most, found = np.full(shape, -1, np.float32), np.zeros(shape, np.uint16)
    for label in shown:
        total = sum(weight * (other == label) for other, weight in zip(shown, weights, strict=True))
        found = np.where(total > most, label, found)
        most = np.maximum(total, most)
    return found
