"""A trained policy as a robot learner uses it: it acts on what the environments of `gym.make` give."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.contracts.trained import read_config
from roomkin.stages.plugins import load
from roomkin.stages.policies.base import (
    ActionMode,
    Float,
    RolloutPolicy,
    TrainablePolicy,
    load_network,
    make_rollout_policy,
)


class LoadedPolicy:
    """policy.reset(seed), then action = policy.act(observation) at every step.

    Attributes:
        env_id: name for `gym.make` of the task that it was trained on.
        task_options: what its environments were made with, for `gym.make(..., options=)`.
    """

    def __init__(self, network: TrainablePolicy, env_id: str, task_options: TaskConfig, action: ActionMode) -> None:
        self.network, self.env_id, self.task_options, self.action = network, env_id, task_options, action
        self.reset()

    def reset(self, seed: int = 0) -> None:
        """Start an episode; `seed` decides every random choice of it, plus one in each further environment."""
        self._seed = seed
        self._acting: RolloutPolicy | None = None  # how many environments there are the first observation says
        self._envs = 0

    def act(self, observation: Mapping[str, Any]) -> Float:
        """Actions (N, 7) in [-1, 1] for the observation of N environments, (7,) for one without a batch axis.

        Args:
            observation: point_cloud (N, P, 4) and proprio (N, 9), of torch or numpy; see `tasks.observation`.

        Raises:
            InputError: it is no such observation, or of another number of environments than since `reset`.
        """
        if not isinstance(observation, Mapping) or not {"point_cloud", "proprio"} <= set(observation):
            what, fix = "has no point_cloud and proprio.", "gym.make(..., obs_mode='pointcloud')"
            raise InputError("observation", what, fix, code="E-POLICY-OBSERVATION")
        clouds, proprio = (torch.as_tensor(observation[key]).cpu().numpy() for key in ("point_cloud", "proprio"))
        if clouds.ndim == 2:
            return self._act(clouds[None], proprio[None])[0]
        return self._act(clouds, proprio)

    def _act(self, clouds: Float, proprio: Float) -> Float:
        count = len(clouds)
        if self._acting is None:
            self._acting, self._envs = make_rollout_policy(self.network, count, self.action), count
            for env_id in range(count):
                self._acting.start_episode(env_id, self._seed + env_id)
        if count != self._envs:
            what = f"is of {count} environments, the episode began with {self._envs}."
            raise InputError("observation", what, "policy.reset()", code="E-POLICY-OBSERVATION")
        return self._acting.get_action(range(count), list(clouds), list(proprio))


def load_policy(
    folder: str | Path, checkpoint: str = "best", action: ActionMode = "sharpened", device: str = "cpu"
) -> LoadedPolicy:
    """The policy in a folder that `training train` wrote, e.g. results/training/door/twin/lite/seed_0.

    Args:
        checkpoint: 'best', 'last', or the name of one of `checkpoints` in config.json.
        action: as in the config section `evaluation`.

    Raises:
        InputError: a file is missing or broken.
    """
    trained = read_config(Path(folder))
    network = load_network(Path(folder), checkpoint, device)
    return LoadedPolicy(network, load("tasks", trained.task).gym_id, trained.task_options, action)
