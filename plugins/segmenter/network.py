"""A U-Net on the level point cloud of a picture: classes, votes for centres, and which pixels are of the same thing."""

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from plugins.pretrained.weights import load_weights
from stages.geometry.cameras import back_project
from stages.geometry.frames import apply

Array = NDArray[np.float64]

WEIGHTS = Path(__file__).with_name("segmenter.safetensors")
WIDTHS = (24, 40, 64, 96, 128)  # channels at strides 2, 4, 8, 16, 32
STRIDE = 2  # pixels of the input per pixel of the output
FLOOR, BACKGROUND, THING = 0, 1, 2  # classes
# Rows and columns to the other pixel, in pixels of the output.
NEIGHBOURS = ((0, 1), (1, 0), (0, 3), (3, 0), (0, 9), (9, 0), (6, 6), (6, -6), (0, 27), (27, 0), (18, 18), (18, -18))
CHANNELS = 11  # x, y, z, normal, known, 1 / depth, rgb
OUTPUTS = 3 + 3 + 1 + len(NEIGHBOURS)  # classes, offset to the centre of the box, log of its radius, same thing
NEAREST = 0.3  # metres: what is nearer counts as far as this


def network_input(depth: Array, rgb: NDArray[np.uint8], intrinsics: Array, frame: Array) -> NDArray[np.float32]:
    """The input of the network for a picture, (CHANNELS, H, W).

    Args:
        depth: (H, W) metres, 0: unknown.
        rgb: (H, W, 3).
        intrinsics: (3, 3) pixels.
        frame: floor_from_camera (4, 4).
    """
    known = depth > 0
    points = np.where(known[..., None], apply(frame, back_project(depth, intrinsics)), 0.0)
    normals = estimate_normals(points, known, frame[:3, 3])
    near = np.where(known, 1 / np.maximum(depth, NEAREST), 0.0)
    layers = [points / [4.0, 4.0, 2.0], normals, known, near, rgb / 127.5 - 1.0]
    return np.concatenate([np.atleast_3d(layer) for layer in layers], axis=-1, dtype=np.float32).transpose(2, 0, 1)


def estimate_normals(points: Array, known: NDArray[np.bool_], camera: Array) -> Array:
    """Unit normals (H, W, 3) towards the camera (3,) of points (H, W, 3), 0 where too few are `known` (H, W)."""
    reach = max(1, round(points.shape[1] / 160))
    size = (2 * reach + 1, 2 * reach + 1)
    weight = cv2.blur(known.astype(float), size)
    mean = cv2.blur(points, size) / np.maximum(weight, 1e-6)[..., None]
    border = np.pad(mean, ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    enough = np.pad(weight > 0.3, reach, mode="edge")
    height, width = known.shape
    rows, columns = slice(reach, reach + height), slice(reach, reach + width)
    low, high = slice(0, height), slice(2 * reach, 2 * reach + height)
    left, right = slice(0, width), slice(2 * reach, 2 * reach + width)
    normal = np.cross(border[rows, right] - border[rows, left], border[high, columns] - border[low, columns])
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)
    sure = known & enough[rows, right] & enough[rows, left] & enough[high, columns] & enough[low, columns]
    away = (normal * (points - camera)).sum(axis=-1) > 0
    return np.where(sure[..., None], np.where(away[..., None], -normal, normal), 0.0)


def _layer(inputs: int, outputs: int, stride: int = 1) -> nn.Sequential:
    convolution = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


class Segmenter(nn.Module):
    """(B, CHANNELS, H, W) -> (B, OUTPUTS, H / 2, W / 2)."""

    def __init__(self) -> None:
        super().__init__()
        inputs = (CHANNELS, *WIDTHS)
        self.down = nn.ModuleList(
            nn.Sequential(_layer(before, width, 2), _layer(width, width))
            for before, width in zip(inputs, WIDTHS, strict=False)
        )
        self.up = nn.ModuleList(
            nn.Sequential(_layer(width + below, width), _layer(width, width)) for width, below in pairwise(WIDTHS)
        )
        self.head = nn.Conv2d(WIDTHS[0], OUTPUTS, 1)

    def forward(self, x: Tensor) -> Tensor:
        """See the class."""
        levels = []
        for down in self.down:
            x = down(x)
            levels.append(x)
        for up, level in zip(reversed(self.up), reversed(levels[:-1]), strict=True):
            x = up(torch.cat([level, functional.interpolate(x, size=level.shape[-2:])], dim=1))
        y: Tensor = self.head(x)
        return y


def load(path: Path = WEIGHTS) -> Segmenter:
    """The network with its weights, ready to be used.

    Raises:
        InputError: the file is not there or holds other weights.
    """
    fix = "no weights are shipped yet: python -m plugins.segmenter train makes them, put them there"
    network: Segmenter = load_weights(Segmenter(), path, fix).to(memory_format=torch.channels_last)
    return network
