"""What a patch encoder is; the encoders lie beside this file (paper A.6)."""

import hashlib
import json
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from stages.config.matching import EncoderOptions
from stages.matching.crop import View
from stages.plugins import load


class Patches(NamedTuple):
    """Foreground patches of a view: features (P, D) float32, positions (P, 2) as x, y in [-1, 1] of the crop."""

    features: NDArray[np.float32]
    positions: NDArray[np.float32]

    @property
    def rows(self) -> NDArray[np.float32]:
        """What is stored: (P, D + 2)."""
        return np.concatenate([self.features, self.positions], axis=1)


class PatchEncoder(Protocol):
    """Made from the options of `matching`. Patches are compared by the L2 distance of their weighted rows."""

    def settings(self) -> dict[str, Any]:
        """What the stored rows depend on, as plain data: another answer makes another feature store."""
        ...

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """Factor (D + 2,) on each column of the rows; `depth`: both sides have depth. Columns with 0 are left out."""
        ...

    def encode(self, views: list[View]) -> list[Patches]:
        """Foreground patches of each view, in order; a view with an empty mask has none."""
        ...


def make_encoder(options: EncoderOptions) -> PatchEncoder:
    """The encoder that the options name."""
    encoder: PatchEncoder = load("encoders", options.encoder)(options)
    return encoder


def settings_digest(options: EncoderOptions, encoder: PatchEncoder) -> str:
    """16 hex digits that name the encoder with all that its stored rows depend on."""
    text = json.dumps([options.encoder, encoder.settings()], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
