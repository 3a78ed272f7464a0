"""Batches of pictures as sensors see them, with the targets of the network."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import maximum, minimum
from torch import Tensor

from plugins.segmenter.network import STRIDE, network_input
from plugins.segmenter.training.pictures import BACKGROUND, NOTHING, Picture, draw_pictures
from plugins.segmenter.training.sensor import photograph, sense_depth, tilt_frame
from plugins.segmenter.training.solids import Array, Rng, Solid
from stages.geometry.cameras import back_project
from stages.geometry.frames import apply

MIRRORED = [1, 4]  # channels of the input that change sign: y of the point and of the normal


@dataclass(frozen=True)
class Batch:
    """Inputs and, for every second pixel, targets.

    inputs: (B, CHANNELS, H, W). owner: (B, h, w) as in `Picture`. area: (B, h, w) pixels of that owner. offset:
    (B, 3, h, w) metres from the pixel's point to the centre of its thing. radius: (B, h, w) of its box, metres.
    known: (B, h, w) where depth is known.
    """

    inputs: Tensor
    owner: Tensor
    area: Tensor
    offset: Tensor
    radius: Tensor
    known: Tensor


def draw(pool: dict[str, list[Solid]], step: int, size: tuple[int, int], count: int, views: int, seed: int) -> Batch:
    """The batch of an update: it depends on seed and step alone, so that a run can be resumed."""
    rng = np.random.default_rng(np.random.SeedSequence((seed, step)))
    return collate([example(picture, rng) for picture in draw_pictures(pool, count, size, views, rng)])


def collate(examples: list[dict[str, NDArray[np.float32]]]) -> Batch:
    """A batch of examples."""
    both = {name: torch.from_numpy(np.stack([each[name] for each in examples])) for name in examples[0]}
    both["inputs"] = both["inputs"].contiguous(memory_format=torch.channels_last)
    return Batch(**both)


def example(picture: Picture, rng: Rng) -> dict[str, NDArray[np.float32]]:
    """The fields of `Batch` for one picture, its sensor drawn at random; half of them mirrored."""
    depth, frame = sense_depth(picture, rng), tilt_frame(picture.frame.astype(float), rng)
    inputs = network_input(depth, photograph(picture.rgb, rng), picture.intrinsics, frame)
    owner = picture.owner[::STRIDE, ::STRIDE].astype(int)
    true = apply(frame, back_project(picture.depth.astype(float), picture.intrinsics))[::STRIDE, ::STRIDE]
    centre, radius, area = boxes(true, owner)
    seen = np.where((depth > 0)[::STRIDE, ::STRIDE, None], inputs[:3, ::STRIDE, ::STRIDE].transpose(1, 2, 0), 0.0)
    offset = (centre - seen * [4.0, 4.0, 2.0]).transpose(2, 0, 1)
    arrays = {
        "inputs": inputs, "owner": owner, "area": area, "offset": offset, "radius": radius,
        "known": (depth > 0)[::STRIDE, ::STRIDE],
    }  # fmt: skip
    if rng.random() < 0.5:
        arrays = {name: value[..., ::-1].copy() for name, value in arrays.items()}
        arrays["inputs"][MIRRORED] *= -1
        arrays["offset"][1] *= -1
    kinds = {"owner": np.int64, "known": np.bool_}
    return {name: value.astype(kinds.get(name, np.float32)) for name, value in arrays.items()}


def boxes(points: Array, owner: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """For every pixel: centre (H, W, 3) and radius (H, W) of its thing's visible box, metres; area (H, W), pixels."""
    index = np.arange(NOTHING + 1)
    counts = np.bincount(owner.ravel(), minlength=NOTHING + 1)
    low, high = np.zeros((NOTHING + 1, 3)), np.zeros((NOTHING + 1, 3))
    for axis in range(3):
        low[:, axis] = minimum(points[..., axis], owner, index)
        high[:, axis] = maximum(points[..., axis], owner, index)
    low[: BACKGROUND + 1] = high[: BACKGROUND + 1] = low[NOTHING] = high[NOTHING] = 0.0
    centre, radius = (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2
    return centre[owner], np.maximum(radius, 0.02)[owner], counts[owner].astype(float)
