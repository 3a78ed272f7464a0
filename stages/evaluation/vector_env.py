"""Episodes of a policy: several environments in step, each with an asset of its own."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Self

import numpy as np
import torch

from roomkin.stages import plugins
from roomkin.stages.config.evaluation import ActingOptions, SceneOptions, SensingOptions
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.policies import Rollout, TaskAsset, TaskAssets
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.contracts.trained import read_config
from roomkin.stages.evaluation.states import Start
from roomkin.stages.plugins import shorten_name
from roomkin.stages.policies.base import RolloutPolicy, TrainablePolicy, load_network, make_rollout_policy
from roomkin.stages.simulation.room import Moment, Recording
from roomkin.stages.tasks.api import EnvWrapper, Observation
from roomkin.stages.tasks.observation import Sensing


@dataclass
class RolloutEpisode:
    """One rollout. `opened`: fraction of the joint's range at the end; `recording`: None if it was not recorded."""

    asset: TaskAsset
    seed: int
    success: bool = False
    official_success: bool = False
    steps: int = 0
    opened: float = 0.0
    recording: Recording | None = None
    moments: list[Moment] = field(default_factory=list)


def roll_out(
    tasks: Sequence[EnvWrapper],
    folders: Mapping[str, Path],
    policy: RolloutPolicy,
    starts: Sequence[Start],
    record: bool = False,
) -> list[RolloutEpisode]:
    """One episode per start, in their order; an episode ends at success or after `max_steps`.

    `folders`: of the assets, by id. An environment that is free takes the next start, whatever its asset.
    """
    episodes = [RolloutEpisode(asset, seed) for asset, seed in starts]
    waiting = list(episodes)
    running: dict[int, RolloutEpisode] = {}  # by environment
    observations: dict[int, Observation] = {}

    def start(env_id: int) -> None:
        running.pop(env_id, None)
        if waiting:
            running[env_id] = episode = waiting.pop(0)
            tasks[env_id].turn_to(folders[episode.asset.asset], episode.asset.joint, episode.asset.size)
            observations[env_id] = tasks[env_id].reset(episode.seed)
            policy.start_episode(env_id, episode.seed)

    def note(env_id: int) -> None:
        if record:
            running[env_id].moments.append(tasks[env_id].env.moment())

    for env_id in range(len(tasks)):
        start(env_id)
    while running:
        env_ids = list(running)
        seen = [observations[env_id] for env_id in env_ids]
        actions = policy.get_action(env_ids, [one["point_cloud"] for one in seen], [one["proprio"] for one in seen])
        for env_id, action in zip(env_ids, actions, strict=True):
            note(env_id)
            episode, result = running[env_id], tasks[env_id].step(action)
            observations[env_id] = result.observation
            episode.success, episode.official_success = result.success, result.official_success
            episode.opened = result.opened
            episode.steps += 1
            if result.done:
                note(env_id)
                if record:
                    episode.recording = tasks[env_id].env.recording(episode.moments)
                start(env_id)
    return episodes


class Acting(NamedTuple):
    """Who acts, as the experiment calls it: the columns of a row that are the same for all episodes.

    seed: of the training.
    """

    target: str
    policy: str
    training_set: str
    run: str
    seed: int
    checkpoint: str


def move_robot(options: TaskConfig, settings: SceneOptions) -> TaskConfig:
    """The options of the task with the robot standing as the test says."""
    if settings.robot_init_noise is None:
        return options
    metres, degrees = settings.robot_init_noise
    return options.model_copy(update={"base_xy": metres, "base_yaw": float(np.deg2rad(degrees))})


def make_sensing(settings: SensingOptions) -> Sensing:
    """How the test's cameras differ from perfect ones."""
    metres, degrees = settings.camera_error
    return Sensing(settings.depth_noise, (metres, float(np.deg2rad(degrees))))


class VectorEnv:
    """Environments that turn from asset to asset: an exchange costs half of a new environment. To be used by `with`.

    Args:
        sensing: how their cameras differ from perfect ones; None: nothing is looked at.
    """

    def __init__(
        self, assets: Path, library: Path, options: TaskConfig, settings: SceneOptions, sensing: Sensing | None = None
    ) -> None:
        self.plan, self.library = read_json(TaskAssets, assets), library
        self.options, self.settings, self.sensing = move_robot(options, settings), settings, sensing
        self.folders = AssetFolders(library)
        self._tasks: list[EnvWrapper] = []
        self._sized = tempfile.TemporaryDirectory(prefix="acdc-sized-")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        for task in self._tasks:
            task.close()
        self._sized.cleanup()

    def tasks(self, count: int, asset: TaskAsset) -> list[EnvWrapper]:
        """So many environments; new ones are made with the asset."""
        asset = self.size_asset(asset)
        environments: type[EnvWrapper] = plugins.load("simulators", self.settings.simulator)
        while len(self._tasks) < count:
            task = environments(
                self.plan.task, self.folder(asset), asset.joint, asset.size, self.options,
                render=self.sensing is not None, cache=Path(self._sized.name), vary_scale=self.settings.vary_scale,
                sensing=self.sensing,
            )  # fmt: skip
            self._tasks.append(task)
        return self._tasks[:count]

    def folder(self, asset: TaskAsset) -> Path:
        """The asset's folder in the library.

        Raises:
            InputError: the library does not have it.
        """
        if asset.asset not in self.folders:
            what = f"has no asset '{asset.asset}'."
            raise InputError(self.library, what, "run the matching stage again", code="E-LIBRARY-ASSET")
        return self.folders[asset.asset]

    def size_asset(self, asset: TaskAsset) -> TaskAsset:
        """The asset at the size that the test gives it: its own, or that of the task."""
        if not self.settings.own_size:
            return asset
        return asset.model_copy(update={"size": read_json(Asset, self.folder(asset) / "asset.json").size})

    def rows(self, acting: Acting, test_asset: str, episodes: Sequence[RolloutEpisode]) -> list[Rollout]:
        """Episodes on a test asset as rows."""
        task, cloud = shorten_name(self.plan.task), self.options.cloud
        return [
            Rollout(
                **acting._asdict(), task=task, cloud=cloud, test_asset=test_asset, asset=one.asset.asset,
                family=one.asset.family, handle=one.asset.handle, handle_length=one.asset.handle_length,
                feature_distance=one.asset.distance, episode=number, initial_state=one.seed, success=one.success,
                official_success=one.official_success, steps=one.steps, opened=round(one.opened, 4),
            )
            for number, one in enumerate(episodes)
        ]  # fmt: skip


class PolicyVectorEnv(VectorEnv):
    """A policy's environments: the task has the options of its demonstrations; the settings say how assets are shown.

    Raises:
        InputError: the policy was trained on another task.
    """

    def __init__(self, policy: Path, assets: Path, library: Path, settings: ActingOptions, device: str) -> None:
        self.policy, self.device = policy, device
        self.acting = settings
        self.trained = read_config(policy)
        super().__init__(assets, library, self.trained.task_options, settings, make_sensing(settings))
        if self.plan.task != self.trained.task:
            what = f"was trained on the task '{self.trained.task}', {assets} is for '{self.plan.task}'."
            raise InputError(policy, what, code="E-POLICY-TASK")
        torch.set_num_threads(1)

    def network(self, checkpoint: str) -> TrainablePolicy:
        """The policy with the weights of a checkpoint."""
        return load_network(self.policy, checkpoint, self.device)

    def episodes(self, network: TrainablePolicy, starts: Sequence[Start], record: bool = False) -> list[RolloutEpisode]:
        """The episodes, in the order of their starts."""
        starts = [(self.size_asset(asset), seed) for asset, seed in starts]
        folders = {asset.asset: self.folder(asset) for asset, _ in starts}
        tasks = self.tasks(min(self.acting.envs, len(starts)), starts[0][0])
        return roll_out(tasks, folders, make_rollout_policy(network, len(tasks), self.acting.action), starts, record)
