"""What a patch encoder is, and the rows that are stored of its patches; the encoders lie beside this file (A.6)."""

import hashlib
import json
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.descriptors import color_weights, patch_colors
from roomkin.stages.plugins import load

STORED_COLUMNS = ["features", "position", "colour"]  # of a stored row
EXTRA_COLUMNS = 5  # columns after the features: position (2), color (3)


class Patches(NamedTuple):
    """Foreground patches of a view: features (P, D) float32, positions (P, 2) as x, y in [-1, 1] of the crop."""

    features: NDArray[np.float32]
    positions: NDArray[np.float32]


class PatchEncoder(Protocol):
    """Made from the options of `matching`. Patches are compared by the L2 distance of their weighted rows."""

    def settings(self) -> dict[str, Any]:
        """What the stored rows depend on, as plain data: another answer makes another feature store."""
        ...

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """Factor (D + 2,) on features and position; `depth`: both sides have depth. Columns with 0 are left out."""
        ...

    def encode(self, views: list[ObjectView]) -> list[Patches]:
        """Foreground patches of each view, in order; a view with an empty mask has none."""
        ...


def make_encoder(options: EncoderOptions) -> PatchEncoder:
    """The encoder that the options name."""
    encoder: PatchEncoder = load("encoders", options.encoder)(options)
    return encoder


def encode_rows(encoder: PatchEncoder, views: list[ObjectView]) -> list[NDArray[np.float16]]:
    """What is stored of every view: rows (P, D + 5) of features, position, and color, whatever their weights."""
    return [
        np.concatenate([found.features, found.positions, patch_colors(view, found.positions)], axis=1, dtype=np.float16)
        for view, found in zip(views, encoder.encode(views), strict=True)
    ]


def column_weights(encoder: PatchEncoder, depth: bool, color: float = 0.0) -> NDArray[np.float32]:
    """Factor (D + 5,) on each column of the stored rows; `color`: that of the colors."""
    return np.concatenate([encoder.weights(depth), color_weights(color)], dtype=np.float32)


def pool_patches(rows: NDArray[np.floating]) -> NDArray[np.float16]:
    """A picture as one vector (4 * (D + 1),): over each quarter of the crop, the sums of features and of patches.

    Both as shares of all patches, so that little depends on how many there are.
    """
    column, row = (rows[:, -EXTRA_COLUMNS : 2 - EXTRA_COLUMNS] > 0).T.astype(int)
    quarters = np.eye(4, dtype=np.float32)[2 * row + column]
    counted = np.concatenate([rows[:, :-EXTRA_COLUMNS], np.ones((len(rows), 1))], axis=1, dtype=np.float32)
    return (quarters.T @ counted / max(len(rows), 1)).ravel().astype(np.float16)


def whole_weights(weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """Factor on each number of `pool_patches` from those on each column of the rows."""
    return np.tile(np.append(weights[:-EXTRA_COLUMNS], np.float32(1)), 4)


def settings_digest(options: EncoderOptions, encoder: PatchEncoder) -> str:
    """16 hex digits that name the encoder with all that its stored rows depend on."""
    text = json.dumps([options.encoder, encoder.settings(), STORED_COLUMNS], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
