"""Patch encoder `dinov2`: the last layer's normalised patch tokens (paper A.6), through `transformers`."""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from transformers import Dinov2Model
from transformers.image_utils import IMAGENET_DEFAULT_MEAN, IMAGENET_DEFAULT_STD

from stages.config.matching import EncoderOptions
from stages.contracts import InputError
from stages.matching.crop import View, cut, foreground, masked_square, patch_positions
from stages.matching.encoders import Patches
from stages.pretrained import load_pretrained, weights_sha256

MEAN, STD = np.array(IMAGENET_DEFAULT_MEAN, np.float32), np.array(IMAGENET_DEFAULT_STD, np.float32)


class Encoder:
    """DINOv2 on the masked crop, resized without regard to its aspect ratio as in the official code."""

    def __init__(self, options: EncoderOptions) -> None:
        self.options, self.coverage = options.dinov2, options.coverage
        self.model = load_pretrained(Dinov2Model, self.options, "matching.dinov2")
        patch = self.model.config.patch_size
        height, width = self.options.height, self.options.width
        if height % patch or width % patch:
            raise InputError(
                "matching.dinov2", f"{height} x {width}: no multiple of {patch}.", "e.g. 224", code="E-PATCH-SIZE"
            )
        self.rows, self.columns = height // patch, width // patch

    def settings(self) -> dict[str, Any]:
        """What a feature store depends on."""
        return {"weights": weights_sha256(self.options), "height": self.options.height, "width": self.options.width}

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """1 on the features, `position` on the patch position; depth is not used."""
        return np.append(np.ones(self.model.config.hidden_size), [self.options.position] * 2).astype(np.float32)

    def encode(self, views: list[View]) -> list[Patches]:
        """Foreground patches of each view; the network sees `batch` pictures at a time."""
        patches: list[Patches] = []
        for start in range(0, len(views), self.options.batch):
            patches += self._encode(views[start : start + self.options.batch])
        return patches

    def _encode(self, views: list[View]) -> list[Patches]:
        grid = (self.rows, self.columns)
        size = (self.options.width, self.options.height)
        nothing = np.zeros((*size[::-1], 3), np.uint8), np.zeros(size[::-1], np.float32)
        crops = [masked_square(cut(view), *size) if view.mask.any() else nothing for view in views]
        pixels = np.stack([(picture / np.float32(255) - MEAN) / STD for picture, _ in crops]).astype(np.float32)
        with torch.inference_mode():
            tokens = self.model(torch.from_numpy(pixels).permute(0, 3, 1, 2)).last_hidden_state[:, 1:]
        features = tokens.reshape(len(views), *grid, -1).numpy()
        kept = [foreground(coverage, *grid, self.coverage) for _, coverage in crops]
        return [Patches(item[keep], patch_positions(*grid)[keep]) for item, keep in zip(features, kept, strict=True)]
