"""Observations of a mask: its shape and what is around it, and what ImageNet's classifier takes it for."""

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from plugins.efficientnet.network import INSTALL, SIZE, Classifier, fill, published_file, to_input
from plugins.names.shape import Shape, measure_shape
from stages.contracts import InputError
from stages.geometry.cameras import back_project
from stages.geometry.frames import transform_points
from stages.matching.crop import GREY, View, cut

Array = NDArray[np.float64]
MARGIN = 1.15  # times the longer side of a mask's box that the classifier sees; chosen
WITHOUT = f"names are right less often without ImageNet's classifier: {INSTALL}"


@dataclass(frozen=True)
class Observed:
    """The observations of a mask.

    Attributes:
        shape: None: there is too little depth.
        classes: (1000,) scores of ImageNet's classes, logits; None: the classifier is not installed.
    """

    shape: Shape | None = None
    classes: Array | None = None


@cache
def classifier() -> Classifier | None:
    """ImageNet's classifier; None: its weights are not installed."""
    try:
        weights = published_file()
    except InputError:
        return None
    return fill(Classifier(), weights)


def observe(rgb: NDArray[np.uint8], depth: Array, mask: NDArray[np.bool_], intrinsics: Array, frame: Array) -> Observed:
    """What a picture shows of a mask with at least one pixel.

    Args:
        rgb: (H, W, 3).
        depth: (H, W) metres, 0: unknown.
        mask: (H, W).
        intrinsics: (3, 3) pixels.
        frame: floor_from_camera (4, 4), z = 0: what things stand on.
    """
    room = transform_points(frame, back_project(depth, intrinsics))
    return Observed(measure_shape(room, depth > 0, mask, float(frame[2, 3])), classify(rgb, mask))


def classify(rgb: NDArray[np.uint8], mask: NDArray[np.bool_]) -> Array | None:
    """Scores (1000,) of ImageNet's classes for a mask, in a grey square a little larger than it."""
    network = classifier()
    if network is None:
        return None
    seen = cut(View(rgb, mask))
    height, width = seen.mask.shape
    side = round(MARGIN * max(height, width))
    square = np.full((side, side, 3), GREY, np.uint8)
    top, left = (side - height) // 2, (side - width) // 2
    square[top : top + height, left : left + width] = np.where(seen.mask[..., None], seen.rgb, GREY)
    method = cv2.INTER_AREA if side > SIZE else cv2.INTER_LINEAR
    picture = cv2.resize(square, (SIZE, SIZE), interpolation=method)
    with torch.inference_mode():
        return np.asarray(network(to_input(np.asarray(picture[None], np.uint8)))[0].double().numpy())
