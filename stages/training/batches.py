"""Training sequences: which frames they are, and the points that they see of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from roomkin.stages.training.dataset import DemonstrationSet

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Batch:
    """Sequences: clouds (B, T, P, 4), proprio (B, T, 9), actions (B, T, 7), weights (B, T): 0 behind an episode.

    fronts: (B, T, 3), as of `DemonstrationSet`.
    """

    clouds: Tensor
    proprio: Tensor
    actions: Tensor
    weights: Tensor
    fronts: Tensor | None = None


def list_windows(data: DemonstrationSet, episodes: Sequence[int], horizon: int, stride: int) -> tuple[Indices, Mask]:
    """Frame indices (W, T) of the sequences that start at every `stride`-th step, and (W, T) which steps are real.

    Behind its end an episode is padded by its last frame, as robomimic does, but with no weight in the loss.
    """
    ends = np.cumsum(data.lengths)
    frames, real = [], []
    for episode in episodes:
        first, end = ends[episode] - data.lengths[episode], ends[episode]
        index = np.arange(first, end, stride)[:, None] + np.arange(horizon)
        frames.append(np.minimum(index, end - 1))
        real.append(index < end)
    return np.concatenate(frames), np.concatenate(real)


def make_batch(
    data: DemonstrationSet, frames: Indices, real: Mask, points: int, random: torch.Generator, keep_handle: bool = False
) -> Batch:
    """Sequences of `frames` (B, T), each seeing its own random `points` of the P points of every cloud.

    keep_handle: the points of handles are never left out.
    """
    device, available = data.clouds.device, data.clouds.shape[1]
    index = torch.from_numpy(frames).to(device)
    if points < available:
        chance = torch.rand((len(index), available), generator=random).to(device)
        order = chance.argsort(1)[:, None].expand(-1, index.shape[1], -1)
        if keep_handle:
            order = put_handle_first(data.clouds[index][..., 3], order)
        clouds = data.clouds[index[:, :, None], order[..., :points]]
    else:
        clouds = data.clouds[index]
    weights = torch.from_numpy(real).to(device).float()
    fronts = None if data.fronts is None else data.fronts[index]
    return Batch(clouds.float(), data.proprio[index], data.actions[index], weights, fronts)


def put_handle_first(flags: Tensor, order: Tensor) -> Tensor:
    """An order (B, T, P) of points in which those with flag -1 come first and all else stays as it was."""
    marked = flags.gather(2, order) == -1
    before = marked.cumsum(2)
    others = torch.arange(order.shape[2], device=order.device) - before
    place = torch.where(marked, before - 1, before[..., -1:] + others)
    return torch.empty_like(order).scatter_(2, place, order)
