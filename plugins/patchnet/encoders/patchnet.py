"""Patch encoder `patchnet`: a small network, trained on renders alone, beside the columns of `hog`.

Network vectors, gradients, normals and positions are stored unweighted, side by side.
"""

import hashlib
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import ValidationError

from plugins.patchnet.network import COLUMNS, GRID, SIZE, WEIGHTS, load, network_input
from stages.config.matching import EncoderOptions, HogConfig
from stages.contracts import InputError
from stages.contracts.files import first_error
from stages.contracts.section import NotNegative, Section
from stages.matching.crop import View, cut, foreground, masked_square
from stages.matching.encoders import Patches, hog
from stages.matching.normals import NORMAL_COLUMNS


class Weights(Section):
    """`matching: {own: {patchnet: ...}}`. What counts how much, when the network's vectors have weight 1.

    Attributes:
        hog: of the gradients.
        normals: of the surface normals; 0: never used.
        position: of a patch's place in the crop, with normals.
        position_alone: the same, without normals.
    """

    hog: NotNegative = 1.0
    normals: NotNegative = 1.8
    position: NotNegative = 1.5
    position_alone: NotNegative = 2.0


class Encoder:
    """The network's unit vectors, then gradients and normals as `hog` has them, on the same patches."""

    def __init__(self, options: EncoderOptions) -> None:
        try:
            self.options = Weights.model_validate(options.own.get("patchnet", {}))
        except ValidationError as error:
            fix = f"the keys are {', '.join(Weights.model_fields)}: numbers of 0 or more"
            raise InputError("matching.own.patchnet", f"{first_error(error)}.", fix, code="E-PATCHNET-OPTION") from None
        self.hog = hog.Encoder(EncoderOptions(hog=HogConfig(image_size=SIZE, grid=GRID)))
        self.network = load()

    def settings(self) -> dict[str, Any]:
        """What a feature store depends on."""
        return {"weights": hashlib.sha256(WEIGHTS.read_bytes()).hexdigest(), "hog": self.hog.settings()}

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """Factors (400,) on the network's columns, gradients, normals and position."""
        normals = self.options.normals if depth else 0.0
        position = self.options.position if normals else self.options.position_alone
        parts = [(1.0, COLUMNS), (self.options.hog, hog.GRADIENT_COLUMNS), (normals, NORMAL_COLUMNS), (position, 2)]
        return np.concatenate([np.full(count, weight, np.float32) for weight, count in parts])

    def encode(self, views: list[View]) -> list[Patches]:
        """Foreground patches of each view; the network sees all pictures of a model at once."""
        seen = [number for number, view in enumerate(views) if view.mask.any()]
        vectors = dict(zip(seen, self._vectors([views[number] for number in seen]), strict=True))
        nothing = np.empty((0, COLUMNS), np.float32)
        return [
            Patches(np.concatenate([vectors.get(number, nothing), patches.features], axis=1), patches.positions)
            for number, patches in enumerate(self.hog.encode(views))
        ]

    def _vectors(self, views: list[View]) -> list[NDArray[np.float32]]:
        """Unit vectors (P, 128) of the foreground patches of each view."""
        if not views:
            return []
        crops = [masked_square(cut(view), SIZE, SIZE) for view in views]
        bytes_ = [np.round(coverage * 255).astype(np.uint8) for _, coverage in crops]
        with torch.inference_mode():
            maps = self.network(network_input(np.stack([picture for picture, _ in crops]), np.stack(bytes_)))
        grids = maps.permute(0, 2, 3, 1).contiguous().numpy()
        return [grid[foreground(coverage, GRID, GRID)] for grid, (_, coverage) in zip(grids, crops, strict=True)]
