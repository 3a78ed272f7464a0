"""What an outline shows: a thing that stands, rests on another or hangs, a wall, the floor, or no thing."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.eyes.mobile_sam import INPUT
from stages.contracts import InputError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
WEIGHTS = Path(__file__).parent / "outline_kinds.safetensors"
STANDS, RESTS, HANGS, WALL, FLOOR, NOTHING = KINDS = ("stands", "rests", "hangs", "wall", "floor", "nothing")
COLUMNS = 779  # numbers of an outline: 3 of each of MobileSAM's 256 channels, 11 of where it lies
AROUND = 7  # cells of the embedding, 16 pixels each, in the square that widens an outline to its surroundings


def tell_kinds(features: NDArray[np.float32], masks: Sequence[Mask]) -> Array:
    """The probability (N, 6) of each of `KINDS` for the outlines (H, W) of a picture.

    Args:
        features: (256, 64, 64), MobileSAM's of the picture.
    """
    weights, bias = read_weights()
    scores = np.array([measure_outline(features, mask) for mask in masks]).reshape(-1, COLUMNS) @ weights + bias
    share = np.exp(scores - scores.max(axis=1, keepdims=True, initial=-np.inf))
    return np.asarray(share / share.sum(axis=1, keepdims=True))


@cache
def read_weights(path: Path = WEIGHTS) -> tuple[Array, Array]:
    """Weights (779, 6) and bias (6,), as `python -m benchmarks.outline_kinds` writes them.

    Raises:
        InputError: the file holds others.
    """
    from safetensors.numpy import load_file

    held = {name: np.asarray(one, float) for name, one in load_file(path).items()}
    if {name: one.shape for name, one in held.items()} != {"weights": (COLUMNS, len(KINDS)), "bias": (len(KINDS),)}:
        raise InputError(path, "holds other weights.", "take the file from the repository", code="E-WEIGHTS-OTHER")
    return held["weights"], held["bias"]


def measure_outline(features: NDArray[np.float32], mask: Mask) -> Array:
    """What the classifier knows of an outline (H, W): (779,).

    The mean of MobileSAM's features inside, around and their spread inside; the box, area and fill of the outline as
    shares of the picture, the logarithm of its width over its height, and which borders it touches.
    """
    height, width = mask.shape
    cells = [max(1, round(side * INPUT / max(mask.shape) / 16)) for side in (height, width)]
    inside, shown = np.zeros((2, *features.shape[1:]), np.float32)
    inside[: cells[0], : cells[1]] = cv2.resize(mask.astype(np.float32), cells[::-1], interpolation=cv2.INTER_AREA)
    shown[: cells[0], : cells[1]] = 1
    around = np.clip(np.asarray(cv2.dilate(inside, np.ones((AROUND, AROUND)))) - inside, 0, 1) * shown
    mean, beside = _average(features, inside), _average(features, around)
    spread = np.sqrt(np.maximum(_average(features**2, inside) - mean**2, 0))
    rows, columns = np.nonzero(mask)
    left, top, right, bottom = columns.min(), rows.min(), columns.max(), rows.max()
    wide, tall = right - left + 1, bottom - top + 1
    box = [left / width, right / width, top / height, bottom / height]
    form = [np.sqrt(mask.mean()), mask.sum() / (wide * tall), np.log(wide / tall)]
    touches = [left < 4, right > width - 5, top < 4, bottom > height - 5]
    return np.concatenate([mean, beside, spread, box, form, touches]).astype(float)


def _average(features: NDArray[np.float32], weight: NDArray[np.float32]) -> NDArray[np.float32]:
    """Means (C,) of features (C, h, w) by weights (h, w)."""
    return np.asarray(np.einsum("chw,hw->c", features, weight) / max(float(weight.sum()), 1e-6))
