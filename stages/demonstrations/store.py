"""episodes.h5: successful episodes in robomimic's layout."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from stages.config.task import TaskConfig
from stages.contracts import atomic
from stages.tasks.api import Observation

Float = NDArray[np.float32]


@dataclass
class RecordedEpisode:
    """What is recorded of one attempt: observations before each action, clean actions, how far the joint was open."""

    seed: int
    point_clouds: list[Float] = field(default_factory=list)
    proprios: list[Float] = field(default_factory=list)
    actions: list[Float] = field(default_factory=list)
    opened: list[float] = field(default_factory=list)

    def add(self, observation: Observation, action: Float, opened: float) -> None:
        """Append one step."""
        self.point_clouds.append(observation["point_cloud"].astype(np.float16))
        self.proprios.append(observation["proprio"])
        self.actions.append(action)
        self.opened.append(opened)


@dataclass(frozen=True)
class StoreHeader:
    """What the episodes have in common."""

    task: str
    environment: str  # its name for gym.make
    asset: str
    joint: str
    size: tuple[float, float, float]
    options: TaskConfig


def write_episodes(path: Path, header: StoreHeader, episodes: Sequence[RecordedEpisode]) -> None:
    """Write a store atomically; the same episodes give the same bytes.

    Layout: `data/demo_i/{obs/point_cloud (T, P, 4) float16, obs/proprio (T, 9) float32, actions (T, 7) float32,
    joint (T,) float32}`, uncompressed so that training can map it; attributes as in robomimic.
    """
    env_args = {
        "env_name": header.environment,
        "type": "maniskill",
        "env_kwargs": {"asset": header.asset, "joint": header.joint, "size": list(header.size)},
    }
    with atomic(path) as temporary, h5py.File(temporary, "w", track_order=True) as file:
        data = file.create_group("data", track_order=True)
        data.attrs["env_args"] = json.dumps(env_args, sort_keys=True)
        data.attrs["total"] = sum(len(episode.actions) for episode in episodes)
        data.attrs["task"] = header.task
        data.attrs["asset"] = header.asset
        data.attrs["task_options"] = header.options.model_dump_json()
        data.attrs["success_fraction"] = header.options.success_fraction
        for index, episode in enumerate(episodes):
            group = data.create_group(f"demo_{index}")
            group.attrs["num_samples"] = len(episode.actions)
            group.attrs["seed"] = episode.seed
            group.attrs["asset"] = header.asset
            for name, values, dtype in (
                ("obs/point_cloud", episode.point_clouds, np.float16),
                ("obs/proprio", episode.proprios, np.float32),
                ("actions", episode.actions, np.float32),
                ("joint", episode.opened, np.float32),
            ):
                group.create_dataset(name, data=np.asarray(values, dtype), track_times=False)
