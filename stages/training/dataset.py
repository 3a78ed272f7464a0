"""Demonstrations in memory: all frames once, in half precision, with the handle and the plane of the front behind it.

A training sequence is an index into them.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from roomkin.stages.contracts.episode_store import read_episodes
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.contracts.trained import TrainingStore
from roomkin.stages.policies.handle_points import segment_handles

FRONT_TURNED, FRONT_PULLED = 0.07, 0.015  # radians, metres in two frames in a row: a front that moves; chosen


def segment_episodes(clouds: Tensor, lengths: Sequence[int]) -> tuple[Tensor, Tensor]:
    """Flagged clouds (F, P, 4) of episodes end to end, and their fronts (F, 3): the first frame's, 0 once it moves."""
    flagged, planes = segment_handles(clouds)
    fronts = torch.zeros_like(planes)
    first = 0
    for length in lengths:
        part = slice(first, first + length)
        fronts[part] = planes[first] * find_still(planes[part])[:, None]
        first += length
    return flagged, fronts


def find_still(planes: Tensor) -> Tensor:
    """Which frames (T,) of an episode come before its front has turned or been pulled; planes (T, 3)."""
    cosine = planes[:, :2] @ planes[0, :2]
    moved = (cosine < torch.cos(torch.tensor(FRONT_TURNED))) | ((planes[:, 2] - planes[0, 2]).abs() > FRONT_PULLED)
    twice = moved & torch.cat([moved[1:], moved[-1:]])
    return twice.cumsum(0) == 0


Float = NDArray[np.float32]
VALIDATION_FRACTION = 0.1  # of the episodes of every store (official: 0.1)


@dataclass(frozen=True)
class DemonstrationSet:
    """Episodes end to end: clouds (F, P, 4) float16, proprio (F, 9), actions (F, 7) float32; robot frame, metres.

    fronts: (F, 3) the upright plane of the front as long as it stands still, else zeros; with `segment_handles` alone.
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

    def segment_handles(self) -> "DemonstrationSet":
        """The same with the handles flagged in the clouds."""
        clouds, fronts = segment_episodes(self.clouds, self.lengths)
        return replace(self, clouds=clouds, fronts=fronts)

    def on(self, device: str) -> "DemonstrationSet":
        """The same with its frames on a device, where batches are then put together."""
        frames = {name: getattr(self, name) for name in ("clouds", "proprio", "actions", "fronts")}
        return replace(self, **{name: frame.to(device) for name, frame in frames.items() if frame is not None})


def steps_until_release(actions: Float) -> int:
    """Steps (of T, 7 actions) until the hand opens for the last time; all of them if it ends closed or never closes."""
    closed = np.flatnonzero(actions[:, 6] < 0)
    return int(closed[-1]) + 1 if len(closed) else len(actions)


def read_demonstrations(
    paths: Sequence[Path], per_store: int, release_included: bool = True, task: str = ""
) -> DemonstrationSet:
    """The first `per_store` episodes of every store; without `release_included` each up to where the hand last opens.

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
    episodes: list[tuple[NDArray[Any], ...]] = [episode for store in stores for episode in store.episodes]
    if not release_included:
        episodes = [tuple(array[: steps_until_release(each[2])] for array in each) for each in episodes]
    clouds, proprio, actions = (np.concatenate(arrays) for arrays in zip(*episodes, strict=True))
    lengths = [len(episode[2]) for episode in episodes]
    store_of = [number for number, store in enumerate(stores) for _ in store.episodes]
    digest = hashlib.sha256()
    for array in (clouds, proprio, actions):
        digest.update(np.ascontiguousarray(array).data)
    frames = np.bincount(store_of, lengths).astype(int).tolist()  # of each store, which all have episodes
    used = [
        TrainingStore(file="/".join(path.parts[-3:]), asset=store.asset, episodes=len(store.episodes), frames=count)
        for path, store, count in zip(paths, stores, frames, strict=True)
    ]
    seen, own, done = map(torch.from_numpy, (clouds, proprio, actions))
    task, options = first.task, first.task_options
    return DemonstrationSet(seen, own, done, lengths, store_of, used, task, options, digest.hexdigest())


def split_episodes(data: DemonstrationSet, seed: int) -> tuple[list[int], list[int]]:
    """Episodes for training and for validation; of every store the same fraction."""
    random = np.random.default_rng((seed, 11))
    validation: list[int] = []
    for store in range(len(data.stores)):
        episodes = [i for i, owner in enumerate(data.store_of) if owner == store]
        count = round(VALIDATION_FRACTION * len(episodes))  # of five or fewer episodes none
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
