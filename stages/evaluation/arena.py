"""The assets of an experiment in environments, and policies acting there."""

import tempfile
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Self

import torch

from stages.config.evaluation import ActingOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from stages.contracts.library_folder import AssetFolders
from stages.contracts.policies import Rollout, TaskAsset, TaskAssets
from stages.contracts.policy_folder import read_config
from stages.contracts.task_options import TaskConfig
from stages.evaluation.episodes import RolloutEpisode, roll_out
from stages.evaluation.states import Start
from stages.policies import TrainablePolicy, closed_loop
from stages.policies.checkpoint import load_policy
from stages.simulation.studio import Studio
from stages.tasks.api import TaskEnv


class Acting(NamedTuple):
    """Who acts, as the experiment calls it: the columns of a row that are the same for all episodes.

    task, assets_of: the experiment's row, and the row whose assets it uses. seed: of the training.
    """

    task: str
    assets_of: str
    training_set: str
    run: str
    seed: int
    checkpoint: str


class Arena:
    """Environments that turn from asset to asset: an exchange costs half of a new environment. To be used by `with`."""

    def __init__(self, assets: Path, library: Path, options: TaskConfig, vary_scale: bool, render: bool = True) -> None:
        self.plan, self.library = read_json(TaskAssets, assets), library
        self.options, self.vary_scale, self.render = options, vary_scale, render
        self.folders = AssetFolders(library)
        self._tasks: list[TaskEnv] = []
        self._sized = tempfile.TemporaryDirectory(prefix="acdc-sized-")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        for task in self._tasks:
            task.close()
        self._sized.cleanup()

    @cached_property
    def studio(self) -> Studio:
        """Where films are made, before the arena closes."""
        return Studio()

    def tasks(self, count: int, asset: TaskAsset) -> list[TaskEnv]:
        """So many environments; new ones are made with the asset."""
        self._tasks += [self.task(asset) for _ in range(count - len(self._tasks))]
        return self._tasks[:count]

    def task(self, asset: TaskAsset) -> TaskEnv:
        """A new environment with the asset."""
        return TaskEnv(
            self.plan.task,
            self.folder(asset),
            asset.joint,
            asset.size,
            self.options,
            render=self.render,
            cache=Path(self._sized.name),
            vary_scale=self.vary_scale,
        )

    def folder(self, asset: TaskAsset) -> Path:
        """The asset's folder in the library.

        Raises:
            InputError: the library does not have it.
        """
        if asset.asset not in self.folders:
            what = f"has no asset '{asset.asset}'."
            raise InputError(self.library, what, "run the matching stage again", code="E-LIBRARY-ASSET")
        return self.folders[asset.asset]

    def rows(self, acting: Acting, role: str, episodes: Sequence[RolloutEpisode]) -> list[Rollout]:
        """Episodes on a test role as rows."""
        return [
            Rollout.model_validate(
                acting._asdict()
                | {
                    "cloud": self.options.cloud,
                    "test_asset": role,
                    "asset": episode.asset.asset,
                    "family": episode.asset.family,
                    "handle": episode.asset.handle,
                    "handle_length": episode.asset.handle_length,
                    "dino_distance": episode.asset.distance,
                    "episode": number,
                    "initial_state": episode.seed,
                    "success": episode.success,
                    "official_success": episode.official_success,
                    "steps": episode.steps,
                    "opened": round(episode.opened, 4),
                }
            )
            for number, episode in enumerate(episodes)
        ]


class PolicyArena(Arena):
    """A policy's arena: the environment is that of its demonstrations.

    Raises:
        InputError: the policy was trained on another task.
    """

    def __init__(self, policy: Path, assets: Path, library: Path, settings: ActingOptions, device: str) -> None:
        self.policy, self.settings, self.device = policy, settings, device
        self.trained = read_config(policy)
        super().__init__(assets, library, self.trained.task_options, settings.vary_scale)
        if self.plan.task != self.trained.task:
            what = f"was trained on the task '{self.trained.task}', {assets} is for '{self.plan.task}'."
            raise InputError(policy, what, code="E-POLICY-TASK")
        torch.set_num_threads(1)

    def network(self, checkpoint: str) -> TrainablePolicy:
        """The policy with the weights of a checkpoint."""
        return load_policy(self.policy, checkpoint, self.device)

    def episodes(self, network: TrainablePolicy, starts: Sequence[Start], record: bool = False) -> list[RolloutEpisode]:
        """The episodes, in the order of their starts."""
        folders = {asset.asset: self.folder(asset) for asset, _ in starts}
        tasks = self.tasks(min(self.settings.envs, len(starts)), starts[0][0])
        return roll_out(tasks, folders, closed_loop(network, len(tasks), self.settings.action), starts, record)
