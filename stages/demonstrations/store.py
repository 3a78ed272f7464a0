"""episodes.h5: successful episodes in robomimic's layout."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.training import RandomiseOptions
from roomkin.stages.contracts import write_atomically
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.tasks.api import Observation

Float = NDArray[np.float32]


@dataclass
class RecordedEpisode:
    """What is recorded of one attempt: observations before each action, the clean action, the one that was executed
    (they differ by noise and disturbance; the executed ones replay the episode), how far the joint was open."""

    seed: int
    asset: str
    joint: str
    size: tuple[float, float, float]  # nominal
    recovery: str | None = None  # what it had to recover from
    point_clouds: list[Float] = field(default_factory=list)
    proprios: list[Float] = field(default_factory=list)
    actions: list[Float] = field(default_factory=list)
    executed: list[Float] = field(default_factory=list)
    opened: list[float] = field(default_factory=list)

    def add(self, observation: Observation, action: Float, executed: Float, opened: float) -> None:
        """Append one step."""
        self.point_clouds.append(observation["point_cloud"].astype(np.float16))
        self.proprios.append(observation["proprio"])
        self.actions.append(action)
        self.executed.append(executed)
        self.opened.append(opened)


def write_episodes(
    path: Path,
    episodes: Sequence[RecordedEpisode],
    task: str,
    environment: str,
    asset: str,
    options: TaskConfig,
    randomise: RandomiseOptions | None = None,
) -> None:
    """Write a store atomically; the same episodes give the same bytes.

    `environment` is the task's name for gym.make; `asset` that of all episodes, or 'all' if they are of several.

    Layout: `data/demo_i/{obs/point_cloud (T, P, 4) float16, obs/proprio (T, 9) float32, actions and executed (T, 7)
    float32, joint (T,) float32, rewards (T,) float32 and dones (T,) uint8: 1 at the end}`, uncompressed so that
    training can map it; attributes as in robomimic, which reads the file as it is. Each demo names its asset, joint
    and nominal size; `env_args` are those of the first; `randomise` are the ranges that a randomised object was drawn
    from, beside `task_options`, which evaluation takes over.
    """
    first = episodes[0]
    env_args = {
        "env_name": environment,
        "type": 2,  # robomimic's EnvType.GYM_TYPE
        "env_kwargs": {"asset": first.asset, "joint": first.joint, "size": list(first.size)},
    }
    with write_atomically(path) as temporary, h5py.File(temporary, "w", track_order=True) as file:
        data = file.create_group("data", track_order=True)
        data.attrs["env_args"] = json.dumps(env_args, sort_keys=True)
        data.attrs["total"] = sum(len(episode.actions) for episode in episodes)
        data.attrs["task"] = task
        data.attrs["asset"] = asset
        data.attrs["task_options"] = options.model_dump_json()
        if randomise:
            data.attrs["randomise"] = randomise.model_dump_json()
        for index, episode in enumerate(episodes):
            group = data.create_group(f"demo_{index}")
            group.attrs["num_samples"] = len(episode.actions)
            group.attrs["seed"] = episode.seed
            group.attrs["asset"], group.attrs["joint"] = episode.asset, episode.joint
            group.attrs["size"] = episode.size
            group.attrs["recovery"] = episode.recovery or "none"
            last = np.arange(len(episode.actions)) == len(episode.actions) - 1
            for name, values, dtype in (
                ("obs/point_cloud", episode.point_clouds, np.float16),
                ("obs/proprio", episode.proprios, np.float32),
                ("actions", episode.actions, np.float32),
                ("executed", episode.executed, np.float32),
                ("joint", episode.opened, np.float32),
                ("rewards", last, np.float32),
                ("dones", last, np.uint8),
            ):
                group.create_dataset(name, data=np.asarray(values, dtype), track_times=False)
