"""Demonstrations in memory: all frames once, in half precision; a training sequence is an index into them."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from stages.contracts.episode_store import read_episodes
from stages.contracts.errors import InputError
from stages.contracts.task_options import TaskConfig
from stages.contracts.trained import TrainingStore
from stages.policies.marking import load_marker

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Float = NDArray[np.float32]


@dataclass(frozen=True)
class DemonstrationSet:
    """Episodes end to end: clouds (F, P, 4) float16, proprio (F, 9), actions (F, 7) float32; robot frame, metres.

    fronts: (F, 3) the upright plane of the front as long as it stands still, else zeros (`policies.marking`); of
    marked clouds alone.
    """

    clouds: Tensor
    proprio: Tensor
    actions: Tensor
    lengths: list[int]
    store_of: list[int]  # which store each episode comes from
    stores: list[TrainingStore]
    task: str
    task_options: TaskConfig
    digest: str
    fronts: Tensor | None = None

    def mark_handles(self) -> "DemonstrationSet":
        """The same with the handles marked in the clouds."""
        clouds, fronts = load_marker().mark_episodes(self.clouds, self.lengths)
        return replace(self, clouds=clouds, fronts=fronts)

    def on(self, device: str) -> "DemonstrationSet":
        """The same with its frames on a device, where batches are then put together."""
        frames = {name: getattr(self, name) for name in ("clouds", "proprio", "actions", "fronts")}
        return replace(self, **{name: frame.to(device) for name, frame in frames.items() if frame is not None})


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


def steps_until_release(actions: Float) -> int:
    """Steps (of T, 7 actions) until the hand opens for the last time; all of them if it ends closed or never closes."""
    closed = np.flatnonzero(actions[:, 6] < 0)
    return int(closed[-1]) + 1 if len(closed) else len(actions)


def read_demonstrations(paths: Sequence[Path], per_store: int, let_go: bool = True, task: str = "") -> DemonstrationSet:
    """The first `per_store` episodes of every store; without `let_go` each up to where the hand last opens.

    `task`: that they must be of; '': any.

    Raises:
        InputError: a file is no episode store, has too few episodes, or differs in task or task options.
    """
    if not paths or per_store < 1:
        what = "name no episodes to train on."
        raise InputError("--episodes, --per-store", what, "at least one store and one episode", code="E-EPISODES-NONE")
    stores = [read_episodes(path, per_store) for path in paths]
    first = stores[0]
    for path, store in zip(paths, stores, strict=True):
        if (store.task, store.task_options) != (first.task, first.task_options):
            what = f"was collected for another task or with other task options than {paths[0]}."
            raise InputError(path, what, code="E-EPISODES-MIXED")
        if task and store.task != task:
            what = f"was collected for the task '{store.task}', not '{task}'."
            raise InputError(path, what, "collect it again", code="E-EPISODES-TASK")
    episodes = [
        episode if let_go else tuple(array[: steps_until_release(episode[2])] for array in episode)
        for store in stores
        for episode in store.episodes
    ]
    clouds, proprio, actions = (np.concatenate(arrays) for arrays in zip(*episodes, strict=True))
    lengths = [len(episode[2]) for episode in episodes]
    store_of = [number for number, store in enumerate(stores) for _ in store.episodes]
    digest = hashlib.sha256()
    for array in (clouds, proprio, actions):
        digest.update(np.ascontiguousarray(array).data)
    return DemonstrationSet(
        clouds=torch.from_numpy(clouds),
        proprio=torch.from_numpy(proprio),
        actions=torch.from_numpy(actions),
        lengths=lengths,
        store_of=store_of,
        stores=[
            TrainingStore(
                file="/".join(path.parts[-3:]),
                asset=store.asset,
                episodes=len(store.episodes),
                frames=sum(length for length, owner in zip(lengths, store_of, strict=True) if owner == number),
            )
            for number, (path, store) in enumerate(zip(paths, stores, strict=True))
        ],
        task=first.task,
        task_options=first.task_options,
        digest=digest.hexdigest(),
    )


def split_episodes(data: DemonstrationSet, fraction: float, seed: int) -> tuple[list[int], list[int]]:
    """Episodes for training and for validation; of every store the same fraction, at least one to train on."""
    random = np.random.default_rng((seed, 11))
    validation: list[int] = []
    for store in range(len(data.stores)):
        episodes = [i for i, owner in enumerate(data.store_of) if owner == store]
        count = min(round(fraction * len(episodes)), len(episodes) - 1)
        validation += random.permutation(episodes)[:count].tolist()
    return [i for i in range(len(data.lengths)) if i not in set(validation)], sorted(validation)


def frames_of(data: DemonstrationSet, episodes: Sequence[int]) -> Tensor:
    """Rows of the frames of some episodes."""
    ends = torch.tensor(data.lengths).cumsum(0)
    return torch.cat([torch.arange(int(ends[i]) - data.lengths[i], int(ends[i])) for i in episodes])


def constant_error(data: DemonstrationSet, training: Sequence[int], validation: Sequence[int]) -> float | None:
    """RMS error, on the validation episodes, of the mean action of the training episodes; None without any of them.

    What a policy reaches that looks at nothing: one that is not below it has learned nothing.
    """
    if not validation:
        return None
    action = data.actions[frames_of(data, training)].mean(0)
    error = (data.actions[frames_of(data, validation)] - action).square().mean().sqrt()
    return round(error.item(), 5)


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


def gather(
    data: DemonstrationSet, frames: Indices, real: Mask, points: int, random: torch.Generator, keep: bool = False
) -> Batch:
    """Sequences of `frames` (B, T), each seeing its own random `points` of the P points of every cloud.

    keep: the points of handles are never left out.
    """
    device, available = data.clouds.device, data.clouds.shape[1]
    index = torch.from_numpy(frames).to(device)
    if points < available:
        chance = torch.rand((len(index), available), generator=random).to(device)
        order = chance.argsort(1)[:, None].expand(-1, index.shape[1], -1)
        if keep:
            order = put_marked_first(data.clouds[index][..., 3], order)
        clouds = data.clouds[index[:, :, None], order[..., :points]]
    else:
        clouds = data.clouds[index]
    weights = torch.from_numpy(real).to(device).float()
    fronts = None if data.fronts is None else data.fronts[index]
    return Batch(clouds.float(), data.proprio[index], data.actions[index], weights, fronts)


def put_marked_first(flags: Tensor, order: Tensor) -> Tensor:
    """An order (B, T, P) of points in which those with flag -1 come first and all else stays as it was."""
    marked = flags.gather(2, order) == -1
    before = marked.cumsum(2)
    others = torch.arange(order.shape[2], device=order.device) - before
    place = torch.where(marked, before - 1, before[..., -1:] + others)
    return torch.empty_like(order).scatter_(2, place, order)
