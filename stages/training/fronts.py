"""Fronts moved under their handles: training sequences in which the handle alone says where the hand must go.

In every demonstration front and handle stay together, so a policy may as well go by the front's borders. Here (not in
the paper; docs/training.md has what it brings) the front of a sequence is shifted and stretched in its own plane;
handle, fingers, proprioception and actions stay as they are. Clouds carry the flags of `policies.proud`.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from stages.config.training import HandleConfig
from stages.policies.proud import mark_proud

if TYPE_CHECKING:
    from stages.training.dataset import Batch

TURNED, PULLED = 0.07, 0.015  # radians, metres: from here on a front moves, if two frames in a row say so
FAR = 10.0  # metres: beyond every cloud


def mark_episodes(clouds: Tensor, lengths: Sequence[int]) -> tuple[Tensor, Tensor]:
    """Marked clouds (F, P, 4) of episodes end to end, and their fronts (F, 3): the first frame's, 0 once it moves."""
    marked, planes = mark_proud(clouds)
    fronts = torch.zeros_like(planes)
    first = 0
    for length in lengths:
        part = slice(first, first + length)
        fronts[part] = planes[first] * still(planes[part])[:, None]
        first += length
    return marked, fronts


def still(planes: Tensor) -> Tensor:
    """Which frames (T,) of an episode come before its front has turned or been pulled; planes (T, 3)."""
    cosine = planes[:, :2] @ planes[0, :2]
    moved = (cosine < torch.cos(torch.tensor(TURNED))) | ((planes[:, 2] - planes[0, 2]).abs() > PULLED)
    twice = moved & torch.cat([moved[1:], moved[-1:]])
    return twice.cumsum(0) == 0


def move_fronts(batch: "Batch", options: HandleConfig, random: torch.Generator) -> "Batch":
    """Some sequences with their fronts shifted along and stretched in their planes, the handle still on them.

    The handle may be stretched about its middle, where it is held. Only sequences in which the front stands still and a
    handle is seen.
    """
    if batch.fronts is None or not options.front_probability:
        return batch
    count, device = len(batch.clouds), batch.clouds.device
    chance = torch.rand((count, 7), generator=random)
    (low, high), (least, most) = options.front_scale, options.scale
    scale = (low + (high - low) * chance[:, 1:3]).to(device)
    shift = ((2 * chance[:, 3:5] - 1) * options.front_shift).to(device)
    own_scale = (least + (most - least) * chance[:, 5:]).to(device)
    xyz, flag = batch.clouds[..., :3], batch.clouds[..., 3]
    handle, front = flag == -1, flag == 0
    able = (
        batch.fronts.any(-1).all(1) & handle.flatten(1).any(1) & (chance[:, 0] < options.front_probability).to(device)
    )

    along = torch.stack([-batch.fronts[:, 0, 1], batch.fronts[:, 0, 0]], dim=-1)  # sideways in the plane
    sideways = (xyz[..., :2] * along[:, None, None]).sum(-1)
    inside = torch.stack([sideways, xyz[..., 2]], dim=-1)  # (B, T, P, 2): sideways and up
    ends = [_ends(inside, which) for which in (handle, front)]
    (handle_low, handle_high), (front_low, front_high) = ends
    middle, half = (handle_low + handle_high) / 2, own_scale * (handle_high - handle_low) / 2
    # A front that ends before its handle does is moved on.
    nearest = middle + half - (middle + scale * (front_high - middle))
    farthest = middle - half - (middle + scale * (front_low - middle))
    shift = torch.maximum(torch.minimum(shift, farthest), nearest)
    from_middle = inside - middle[:, None, None]
    moved = from_middle * (scale[:, None, None] - 1) + shift[:, None, None]
    stretched = from_middle * (own_scale[:, None, None] - 1)
    delta = torch.where(front[..., None], moved, torch.where(handle[..., None], stretched, 0.0))
    delta = delta * able[:, None, None, None]
    flat = delta[..., :1] * along[:, None, None]
    return replace(batch, clouds=torch.cat([xyz + torch.cat([flat, delta[..., 1:]], -1), flag[..., None]], dim=-1))


def _ends(places: Tensor, which: Tensor) -> tuple[Tensor, Tensor]:
    """Lowest and highest place (B, 2) of the points (B, T, P, 2) where `which` (B, T, P) holds."""
    chosen = which[..., None]
    low = torch.where(chosen, places, FAR).flatten(1, 2).amin(1)
    return low, torch.where(chosen, places, -FAR).flatten(1, 2).amax(1)
