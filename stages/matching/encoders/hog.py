"""Patch encoder `hog`: histograms of unsigned gradients around every patch at three scales, and surface normals.

It needs no weights. Its three parts (gradients 243, normals 27, position 2) are stored unweighted, so that
weights can change without encoding anew and an object without depth is compared without normals.
"""

from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.geometry.masks import ObjectView, cut, foreground, masked_square, patch_positions
from roomkin.stages.matching.descriptors import NORMAL_COLUMNS, neighbourhood, patch_normals
from roomkin.stages.matching.encoders import Patches

GRADIENT_BINS = 9  # over half a turn (Dalal and Triggs 2005)
CELL_STEPS = (1, 2, 4)  # distance in patches between the 3 x 3 cells of a descriptor
GRADIENT_COLUMNS = len(CELL_STEPS) * 9 * GRADIENT_BINS  # of a descriptor of 3 x 3 cells
WEAKEST_GRADIENT = 0.02  # gradients weaker than this share of full contrast per pixel do not count as structure; chosen
LARGEST_SHARE = 0.2  # of a descriptor's length, that one number has (L2-Hys; Dalal and Triggs 2005)


class Encoder:
    """Dense HOG + normals + position (the weights were tuned on renderings, see docs/results/matching.md)."""

    def __init__(self, options: EncoderOptions) -> None:
        self.options = options.hog

    def settings(self) -> dict[str, Any]:
        """What a feature store depends on."""
        size, grid = self.options.image_size, self.options.grid
        return {"image_size": size, "grid": grid, "bins": GRADIENT_BINS, "scales": CELL_STEPS}

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """Factors (272,) on gradients, normals and position."""
        normals = self.options.normals if depth else 0.0
        position = self.options.position if normals else self.options.position_alone
        parts = [(1.0, GRADIENT_COLUMNS), (normals, NORMAL_COLUMNS), (position, 2)]
        return np.concatenate([np.full(count, weight, np.float32) for weight, count in parts])

    def encode(self, views: list[ObjectView]) -> list[Patches]:
        """Foreground patches of each view."""
        return [self._encode(view) for view in views]

    def _encode(self, view: ObjectView) -> Patches:
        size, grid = self.options.image_size, self.options.grid
        if not view.mask.any():
            return Patches(np.empty((0, GRADIENT_COLUMNS + NORMAL_COLUMNS), np.float32), np.empty((0, 2), np.float32))
        view = cut(view)
        picture, coverage = masked_square(view, size, size)
        kept = foreground(coverage, grid, grid)
        gradients = descriptors(cell_histograms(picture, grid))[kept]
        normals = neighbourhood(patch_normals(view, grid))[kept]
        return Patches(np.concatenate([gradients, normals], axis=1), patch_positions(grid, grid)[kept])


@cache
def _cell_offsets(size: int, grid: int) -> NDArray[np.int32]:
    """For every pixel of a (size, size) picture: index of its cell's first bin."""
    cell = (np.arange(size) * grid // size).astype(np.int32)
    return ((cell[:, None] * grid + cell[None, :]) * GRADIENT_BINS).ravel()


def cell_histograms(picture: NDArray[np.uint8], grid: int) -> NDArray[np.float32]:
    """Histograms (grid, grid, 9) of the gradient directions modulo pi, weighted by magnitude.

    Of the three color channels each pixel takes the one with the strongest gradient, so that parts of
    equal brightness still have an edge between them.
    """
    size = picture.shape[0]
    image = cv2.GaussianBlur(picture.astype(np.float32) / 255, (3, 3), 0)
    dx, dy = cv2.Sobel(image, cv2.CV_32F, 1, 0, ksize=1), cv2.Sobel(image, cv2.CV_32F, 0, 1, ksize=1)
    red, green, blue = cv2.split(dx * dx + dy * dy)
    is_green, is_blue = green > red, blue > np.maximum(red, green)
    for slope in (dx, dy):
        np.copyto(slope[..., 0], slope[..., 1], where=is_green)
        np.copyto(slope[..., 0], slope[..., 2], where=is_blue)
    dx, dy = np.ascontiguousarray(dx[..., 0]), np.ascontiguousarray(dy[..., 0])
    magnitude, angle = cv2.cartToPolar(dx, dy)
    position = (angle * (GRADIENT_BINS / np.pi)).ravel()
    lower = np.floor(position)
    share = position - lower
    first = lower.astype(np.int32) % GRADIENT_BINS
    second = (first + 1) % GRADIENT_BINS
    offsets, magnitude = _cell_offsets(size, grid), magnitude.ravel()
    count = grid * grid * GRADIENT_BINS
    histogram = np.bincount(offsets + first, magnitude * (1 - share), count)
    histogram += np.bincount(offsets + second, magnitude * share, count)
    return (histogram / (size / grid) ** 2).reshape(grid, grid, GRADIENT_BINS).astype(np.float32)


def descriptors(cells: NDArray[np.float32]) -> NDArray[np.float32]:
    """Unit descriptors (grid, grid, 243): around each patch 3 x 3 cells at each of three scales.

    Each scale is normalised by itself as in Dalal and Triggs (L2, clip, L2).
    """
    grid, parts = cells.shape[0], []
    for scale in CELL_STEPS:
        width = 2 * scale - 1
        blurred = cv2.blur(cells, (width, width), borderType=cv2.BORDER_CONSTANT) if scale > 1 else cells
        padded = np.pad(blurred, ((scale, scale), (scale, scale), (0, 0)))
        steps = (0, scale, 2 * scale)
        block = np.concatenate([padded[y : y + grid, x : x + grid] for y in steps for x in steps], axis=-1)
        block /= np.sqrt((block**2).sum(-1, keepdims=True) + WEAKEST_GRADIENT**2)
        np.minimum(block, LARGEST_SHARE, out=block)
        parts.append(block / np.sqrt((block**2).sum(-1, keepdims=True) + 1e-6))
    return (np.concatenate(parts, axis=-1) / np.sqrt(len(CELL_STEPS))).astype(np.float32)
