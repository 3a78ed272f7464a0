"""Patch encoder `dinov2`: the last layer's normalised patch tokens (paper A.6)."""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from roomkin.plugins.pretrained.dinov2 import load_dinov2
from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.config.weights import DINOV2, weights_sha256
from roomkin.stages.contracts import InputError
from roomkin.stages.geometry.crop import View, cut, foreground, masked_square, patch_positions
from roomkin.stages.matching.encoders import Patches

MEAN, STD = np.array([0.485, 0.456, 0.406], np.float32), np.array([0.229, 0.224, 0.225], np.float32)  # ImageNet's


class Encoder:
    """DINOv2 on the masked crop, resized without regard to its aspect ratio as in the official code."""

    def __init__(self, options: EncoderOptions) -> None:
        self.options = options.dinov2
        self.network = load_dinov2(self.options.path, "matching.dinov2.path")
        self.width, patch = self.network.last.normalized_shape[0], self.network.patch
        height, width = self.options.height, self.options.width
        if height % patch or width % patch:
            what = f"{height} x {width}: no multiple of {patch}."
            raise InputError("matching.dinov2", what, "e.g. 224", code="E-PATCH-SIZE")
        self.rows, self.columns = height // patch, width // patch

    def settings(self) -> dict[str, Any]:
        """The settings that a feature store depends on."""
        return {
            "weights": weights_sha256(self.options.path) if self.options.path else DINOV2.sha256,
            "height": self.options.height,
            "width": self.options.width,
        }

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """1 on the features, 0 on the patch position; depth is not used."""
        return np.append(np.ones(self.width), [0, 0]).astype(np.float32)

    def encode(self, views: list[View]) -> list[Patches]:
        """Foreground patches of each view."""
        return [self._encode(view) for view in views]

    def _encode(self, view: View) -> Patches:
        grid = (self.rows, self.columns)
        if not view.mask.any():
            return Patches(np.empty((0, self.width), np.float32), np.empty((0, 2), np.float32))
        picture, coverage = masked_square(cut(view), self.options.width, self.options.height)
        pixels = ((picture / np.float32(255) - MEAN) / STD).astype(np.float32)
        with torch.inference_mode():
            tokens = self.network(torch.from_numpy(pixels).permute(2, 0, 1)[None])[0]
        kept = foreground(coverage, *grid)
        return Patches(tokens.reshape(*grid, -1).numpy()[kept], patch_positions(*grid)[kept])
