"""What is observed of a mask: how it looks, how large it is, how high its foot is."""

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional

from plugins.efficientnet.network import SIZE, EfficientNet, load, to_input
from stages.contracts.category import log_extents
from stages.geometry.cameras import back_project
from stages.geometry.frames import apply
from stages.matching.crop import View, cut, foreground, masked_square

Array = NDArray[np.float64]
GRID = SIZE // 16  # features per side of a crop
TRIM = 0.02  # share of points left out at either end; chosen
LEAST_POINTS = 20  # that say how large a thing is; chosen
LEAST_SIDE = 0.005  # metres


@dataclass(frozen=True)
class Observed:
    """looks (112,): mean unit feature of its patches; size (3,): logarithms of what is seen of its ground plan's
    shorter and longer side and its height, metres; foot: metres above what things stand on. Without depth neither."""

    looks: Array
    size: Array | None
    foot: float | None


@cache
def network() -> EfficientNet:
    """The network, loaded once per process."""
    return load(16)


def observe(rgb: NDArray[np.uint8], depth: Array, mask: NDArray[np.bool_], intrinsics: Array, frame: Array) -> Observed:
    """What a picture shows of a mask with at least one pixel.

    Args:
        rgb: (H, W, 3).
        depth: (H, W) metres, 0: unknown.
        mask: (H, W).
        intrinsics: (3, 3) pixels.
        frame: floor_from_camera (4, 4), z = 0: what things stand on.
    """
    points = apply(frame, back_project(depth, intrinsics)[mask & (depth > 0)])
    if len(points) < LEAST_POINTS:
        return Observed(see(rgb, mask), None, None)
    low, high = np.quantile(points, [TRIM, 1 - TRIM], axis=0)
    inside = ((points >= low) & (points <= high)).all(axis=1)
    _, sides, _ = cv2.minAreaRect(points[inside][:, :2].astype(np.float32))
    size = np.maximum([*sides, high[2] - low[2]], LEAST_SIDE)
    return Observed(see(rgb, mask), log_extents(size), float(low[2]))


def see(rgb: NDArray[np.uint8], mask: NDArray[np.bool_]) -> Array:
    """Mean (112,) of the unit features of a mask's patches."""
    picture, coverage = masked_square(cut(View(rgb, mask)), SIZE, SIZE)
    with torch.inference_mode():
        features = functional.normalize(network()(to_input(picture[None])), dim=1)[0].permute(1, 2, 0).double().numpy()
    return np.asarray(features[foreground(coverage, GRID, GRID)].mean(axis=0))
