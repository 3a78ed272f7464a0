"""What is observed of a mask: how it looks, how large it is, how high its foot is."""

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional

from plugins.efficientnet.network import (
    INSTALL,
    SIZE,
    Classifier,
    EfficientNet,
    fill,
    load,
    published_file,
    to_input,
)
from stages.contracts import InputError
from stages.contracts.category import log_extents
from stages.geometry.cameras import back_project
from stages.geometry.frames import apply
from stages.geometry.masks import pixel_bounds
from stages.geometry.room_planes import WallPlane, fit_wall
from stages.matching.crop import GREY, View, cut, foreground, masked_square

Array = NDArray[np.float64]
GRID = SIZE // 16  # features per side of a crop
MARGIN = 1.15  # times the longer side of a mask's box that the classifier sees; chosen
TRIM = 0.02  # share of points left out at either end; chosen
LEAST_POINTS = 20  # that say how large a thing is; chosen
LEAST_SIDE = 0.005  # metres
AROUND, LEAST_AROUND = 0.1, 4  # share of a mask's diagonal, and pixels, that are looked at around it; chosen
WITHOUT = f"names are right less often without ImageNet's classifier: {INSTALL}"
LEAST_WALL = 0.35  # share of what is around that a wall has; chosen


@dataclass(frozen=True)
class Observed:
    """What is observed of a mask.

    Attributes:
        looks: (112,) mean unit feature of its patches.
        classes: (1000,) scores of ImageNet's classes, logits; None: the classifier is not installed.
        size: (3,) logarithms of what is seen of its ground plan's shorter and longer side and its height, metres.
        foot: metres above what things stand on.
        out: (2,) metres by which its farthest and its nearest points stand out of the upright plane around it; None:
            there is none. Without depth there is neither size nor foot nor out.
    """

    looks: Array
    classes: Array | None = None
    size: Array | None = None
    foot: float | None = None
    out: Array | None = None


@cache
def network() -> EfficientNet:
    """The network, loaded once per process."""
    return load(16)


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
    room, known = apply(frame, back_project(depth, intrinsics)), depth > 0
    points = room[mask & known]
    looks, classes = see(rgb, mask), classify(rgb, mask)
    if len(points) < LEAST_POINTS:
        return Observed(looks, classes)
    low, high = np.quantile(points, [TRIM, 1 - TRIM], axis=0)
    inside = ((points >= low) & (points <= high)).all(axis=1)
    _, sides, _ = cv2.minAreaRect(points[inside][:, :2].astype(np.float32))
    size = np.maximum([*sides, high[2] - low[2]], LEAST_SIDE)
    wall = find_wall_around(room, known, mask, float(frame[2, 3]))
    out = None if wall is None else np.quantile(points @ wall.normal - wall.offset, [TRIM, 1 - TRIM])
    return Observed(looks, classes, log_extents(size), float(low[2]), out)


def find_wall_around(
    points: Array, known: NDArray[np.bool_], mask: NDArray[np.bool_], camera_height: float
) -> WallPlane | None:
    """The upright plane of most of what is seen around a mask; None: there is none.

    Args:
        points: (H, W, 3) metres, z up, the camera at (0, 0, `camera_height`).
        known: (H, W) where there is depth.
        mask: (H, W).
    """
    x0, y0, x1, y1 = pixel_bounds(mask)
    reach = max(LEAST_AROUND, round(AROUND * float(np.hypot(x1 - x0, y1 - y0))))
    wide = cv2.dilate(mask.astype(np.uint8), np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)) > 0
    around = points[wide & ~mask & known]
    wall = fit_wall(around, camera_height, np.random.default_rng(0))
    return wall if wall is not None and wall.inliers > LEAST_WALL * len(around) else None


def see(rgb: NDArray[np.uint8], mask: NDArray[np.bool_]) -> Array:
    """Mean (112,) of the unit features of a mask's patches."""
    picture, coverage = masked_square(cut(View(rgb, mask)), SIZE, SIZE)
    with torch.inference_mode():
        features = functional.normalize(network()(to_input(picture[None])), dim=1)[0].permute(1, 2, 0).double().numpy()
    return np.asarray(features[foreground(coverage, GRID, GRID)].mean(axis=0))


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
