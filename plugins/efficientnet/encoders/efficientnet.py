"""Patch encoder `efficientnet`: features of an ImageNet network, in place of the paper's DINOv2 (A.6)."""

import hashlib
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional

from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.contracts.section import NotNegative, Section
from roomkin.stages.geometry.masks import ObjectView, cut, foreground, masked_square, patch_positions
from roomkin.stages.matching.encoders import Patches
from roomkin.stages.perception.classification.efficientnet import COLUMNS, SIZE, STRIDE, load, to_input
from roomkin.stages.plugins import parse_kwargs

GRID = SIZE // STRIDE  # patches per side


class Options(Section):
    """`matching: {kwargs: {efficientnet: ...}}`.

    Attributes:
        position: weight of a patch's place in the crop against its features.
    """

    position: NotNegative = 0.5


class Encoder:
    """Unit features of every patch; the crop's aspect ratio is not kept, as in the official code."""

    def __init__(self, options: EncoderOptions) -> None:
        self.options = parse_kwargs(Options, options.kwargs.get("efficientnet", {}), "matching.kwargs.efficientnet")
        self.network = load()

    def settings(self) -> dict[str, Any]:
        """The settings that a feature store depends on."""
        digest = hashlib.sha256()
        for weight in self.network.state_dict().values():
            digest.update(weight.numpy().tobytes())
        return {"weights": digest.hexdigest(), "stride": STRIDE}

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """1 on the features, the option's on the position; depth is not used."""
        return np.append(np.ones(COLUMNS), [self.options.position] * 2).astype(np.float32)

    def encode(self, views: list[ObjectView]) -> list[Patches]:
        """Foreground patches of each view."""
        return [self._encode(view) for view in views]  # one by one: larger batches are slower on a CPU

    def _encode(self, view: ObjectView) -> Patches:
        if not view.mask.any():
            return Patches(np.empty((0, COLUMNS), np.float32), np.empty((0, 2), np.float32))
        picture, coverage = masked_square(cut(view), SIZE, SIZE)
        with torch.inference_mode():
            features = functional.normalize(self.network(to_input(picture[None])), dim=1)
        grid = features[0].permute(1, 2, 0).numpy()
        kept = foreground(coverage, GRID, GRID)
        return Patches(grid[kept], patch_positions(GRID, GRID)[kept])
