"""Training sequences: which frames they are, what they see, moved and jittered at random (paper B.3).

Random numbers are drawn on the host and carried to where the sequences are: the same ones on every device.

In every demonstration front and handle stay together, so a policy may as well go by the front's borders: here the
front is shifted and stretched in its own plane, while handle, hand and actions stay (not in the paper). A knob is
hidden by the fingers when they come near, and spreads them wider than a bar: here handles disappear near the hand, and
grips are wider. docs/policies.md has what each brings. Clouds carry the flags of `handle_points`; metres, base frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from roomkin.stages.contracts.policy_config import PolicyConfig
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


TRANSLATION_PROBABILITY = 0.4  # per sequence (official: 0.4)
JITTER_PROBABILITY, JITTER_CLIP = 0.1, 0.015  # per sequence (official: 0.1, switched off); largest, metres (official)


def augment(clouds: Tensor, proprio: Tensor, config: PolicyConfig, random: torch.Generator) -> tuple[Tensor, Tensor]:
    """Augmented copies of clouds (B, T, P, 4) and proprioception (B, T, 9), both metres in the robot frame.

    `translation_mode: sequence` shifts cloud and end-effector position of a sequence together: the actions are
    deltas, so the shifted sequence is a true one. `cloud_only` is what the official code does: a new shift per step,
    end-effector position untouched.
    """
    batch, steps, points = clouds.shape[:3]
    together = config.translation_mode == "sequence"
    drawn = 1 if together else steps
    shifted = torch.rand((batch, drawn, 1), generator=random) < TRANSLATION_PROBABILITY
    shift = ((2 * torch.rand((batch, drawn, 3), generator=random) - 1) * config.translation * shifted).to(clouds.device)
    xyz = clouds[..., :3] + shift[:, :, None]
    position = proprio[..., :3] + (shift if together else 0.0)

    shaken = (torch.rand(batch, generator=random) < JITTER_PROBABILITY).nonzero().squeeze(1)
    if config.jitter > 0 and len(shaken):
        noise = torch.randn((len(shaken), steps, points, 3), generator=random) * config.jitter
        xyz[shaken.to(clouds.device)] += noise.clamp(-JITTER_CLIP, JITTER_CLIP).to(clouds.device)
    return torch.cat([xyz, clouds[..., 3:]], dim=-1), torch.cat([position, proprio[..., 3:]], dim=-1)


HIDING = 0.05  # metres between hand and handle, below which the fingers may hide it; chosen
HOLDING = (0.002, 0.02)  # metres of a finger joint with something between the fingers; chosen


# How sequences are varied; chosen on validation assets (docs/results/policies.md).
FRONT_PROBABILITY = 0.8  # share of sequences whose front is shifted and stretched under its handle
FRONT_SHIFT = 0.1  # uniform +/- metres along the front, sideways and up
FRONT_SCALE = (0.6, 1.6)  # stretch of the front about the handle, per axis
HANDLE_SCALE = (0.2, 1.5)  # stretch of the handle about its middle, per axis, in these sequences
WIDER_GRIP = 0.012  # metres that each finger may stop farther out, as at a knob
HIDDEN = 0.5  # share of sequences in which the handle is not seen from near, as a knob is


def vary_handles(batch: Batch, random: torch.Generator) -> Batch:
    """The sequences with fronts that moved, wider grips and hidden handles."""
    return hide_handles(widen_grips(move_fronts(batch, random), random), random)


def move_fronts(batch: Batch, random: torch.Generator) -> Batch:
    """Some sequences with their fronts shifted along and stretched in their planes, the handle still on them.

    The handle may be stretched about its middle, where it is held. Only sequences in which the front stands still and a
    handle is seen.
    """
    if batch.fronts is None:
        return batch
    count, device = len(batch.clouds), batch.clouds.device
    chance = torch.rand((count, 7), generator=random)
    (low, high), (least, most) = FRONT_SCALE, HANDLE_SCALE
    scale = (low + (high - low) * chance[:, 1:3]).to(device)
    shift = ((2 * chance[:, 3:5] - 1) * FRONT_SHIFT).to(device)
    own_scale = (least + (most - least) * chance[:, 5:]).to(device)
    xyz, flag = batch.clouds[..., :3], batch.clouds[..., 3]
    handle, front = flag == -1, flag == 0
    able = batch.fronts.any(-1).all(1) & handle.flatten(1).any(1) & (chance[:, 0] < FRONT_PROBABILITY).to(device)

    along = torch.stack([-batch.fronts[:, 0, 1], batch.fronts[:, 0, 0]], dim=-1)  # sideways in the plane
    sideways = (xyz[..., :2] * along[:, None, None]).sum(-1)
    inside = torch.stack([sideways, xyz[..., 2]], dim=-1)  # (B, T, P, 2): sideways and up
    ends = [_bound_places(inside, which) for which in (handle, front)]
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
    delta = torch.where(able[:, None, None, None], delta, 0.0)
    flat = delta[..., :1] * along[:, None, None]
    return replace(batch, clouds=torch.cat([xyz + torch.cat([flat, delta[..., 1:]], -1), flag[..., None]], dim=-1))


def _bound_places(places: Tensor, which: Tensor) -> tuple[Tensor, Tensor]:
    """Lowest and highest place (B, 2) of the points (B, T, P, 2) where `which` (B, T, P) holds."""
    chosen = which[..., None]
    low = torch.where(chosen, places, torch.inf).flatten(1, 2).amin(1)
    return low, torch.where(chosen, places, -torch.inf).flatten(1, 2).amax(1)


def widen_grips(batch: Batch, random: torch.Generator) -> Batch:
    """The sequences with fingers that stop up to `WIDER_GRIP` farther out, each, where they hold something."""
    chance = WIDER_GRIP * torch.rand((len(batch.clouds), 1), generator=random).to(batch.clouds.device)
    fingers = batch.proprio[..., 7:]
    wider = chance * ((fingers > HOLDING[0]) & (fingers < HOLDING[1])).all(-1)  # (B, T)
    w, x, y, z = batch.proprio[..., 3:7].unbind(-1)
    # From finger to finger.
    across = torch.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], dim=-1)
    xyz, flag = batch.clouds[..., :3], batch.clouds[..., 3:]
    side = ((xyz - batch.proprio[..., None, :3]) * across[:, :, None]).sum(-1, keepdim=True).sign()
    xyz = xyz + side * across[:, :, None] * wider[..., None, None] * (flag == 1)
    proprio = torch.cat([batch.proprio[..., :7], fingers + wider[..., None]], dim=-1)
    return replace(batch, clouds=torch.cat([xyz, flag], dim=-1), proprio=proprio)


def hide_handles(batch: Batch, random: torch.Generator) -> Batch:
    """Some sequences in which the handle is not seen while the hand is near it; other points take its points' place."""
    chosen = (torch.rand(len(batch.clouds), generator=random) < HIDDEN).to(batch.clouds.device)
    handle = batch.clouds[..., 3] == -1
    weight = handle.float()[..., None]
    middle = (batch.clouds[..., :3] * weight).sum(2) / weight.sum(2).clamp_min(1)
    near = ((middle - batch.proprio[..., :3]).norm(dim=-1) < HIDING) & chosen[:, None]
    hidden = handle & near[..., None]
    others = batch.clouds.roll(batch.clouds.shape[2] // 2, dims=2)
    return replace(batch, clouds=torch.where(hidden[..., None], others, batch.clouds))
