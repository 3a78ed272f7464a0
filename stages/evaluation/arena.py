"""A policy on the assets of an experiment, in the environment of its demonstrations."""

from functools import cached_property
from pathlib import Path

import torch

from stages.config.evaluation import ActingOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from stages.contracts.library import Library
from stages.contracts.policies import Rollout, TaskAsset, TaskAssets
from stages.contracts.policy_folder import read_config
from stages.evaluation.episodes import RolloutEpisode, roll_out
from stages.evaluation.film import Reel, take
from stages.policies import TrainablePolicy, closed_loop
from stages.policies.checkpoint import load_policy
from stages.simulation.studio import Studio
from stages.tasks.api import TaskEnv, make_task

FIRST_STATE = 2**31  # demonstrations use seeds below: no policy is tested on a state that it was shown
TRIAL_STATE = FIRST_STATE + 2**30  # states that choose a policy are not those that it is judged by
Played = list[tuple[TaskAsset, RolloutEpisode]]


def initial_states(first: int, seed: int, count: int) -> list[int]:
    """Seeds of the initial states of a run of the workflow, from `first` on."""
    return [first + seed * 10_000 + i for i in range(count)]


class Arena:
    """A policy and the assets that it is rolled out on.

    Raises:
        InputError: the policy was trained on another task.
    """

    def __init__(self, policy: Path, assets: Path, library: Path, settings: ActingOptions, device: str) -> None:
        self.policy, self.assets, self.library, self.settings, self.device = policy, assets, library, settings, device
        self.trained, self.plan = read_config(policy), read_json(TaskAssets, assets)
        if self.plan.task != self.trained.task:
            what = f"was trained on the task '{self.trained.task}', {assets} is for '{self.plan.task}'."
            raise InputError(policy, what)
        torch.set_num_threads(1)
        entries = read_json(Library, library).assets
        self.folders = {entry.id: library.parent / entry.folder for entry in entries}

    def network(self, checkpoint: str) -> TrainablePolicy:
        """The policy with the weights of a checkpoint."""
        return load_policy(self.policy, checkpoint, self.device)

    def test(
        self, network: TrainablePolicy, assets: list[TaskAsset], states: list[int], reel: Reel | None = None
    ) -> Played:
        """One episode per initial state, the assets taking turns; of the first one some are filmed on the `reel`.

        Of more assets than states some are left out, evenly over the list.
        """
        turns = min(len(assets), len(states))
        played: dict[int, tuple[TaskAsset, RolloutEpisode]] = {}
        for turn in range(turns):
            asset, shared = assets[turn * len(assets) // turns], states[turn::turns]
            episodes = self.episodes(network, asset, shared, None if turn else reel)
            played |= {state: (asset, episode) for state, episode in zip(shared, episodes, strict=True)}
        return [played[state] for state in states]

    def episodes(
        self, network: TrainablePolicy, asset: TaskAsset, states: list[int], reel: Reel | None = None
    ) -> list[RolloutEpisode]:
        """One episode per initial state; a success and a failure are filmed if there is a reel."""
        tasks = [self.task(asset) for _ in range(min(self.settings.envs, len(states)))]
        actor = closed_loop(network, len(tasks), self.settings.action)
        try:
            episodes = roll_out(tasks, actor, states, record=reel is not None)
            if reel is not None:
                reel.films += take(self.studio, episodes, asset.role, asset.asset, reel.frames)
            return episodes
        finally:
            for task in tasks:
                task.close()

    @cached_property
    def studio(self) -> Studio:
        """Where films are made."""
        return Studio()

    def task(self, asset: TaskAsset) -> TaskEnv:
        """A new environment with the asset."""
        if asset.asset not in self.folders:
            raise InputError(self.library, f"has no asset '{asset.asset}'.", "run the matching stage again")
        return make_task(
            self.trained.task,
            self.folders[asset.asset],
            asset.joint,
            asset.size,
            self.trained.task_options,
            vary_scale=self.settings.vary_scale,
        )

    def rows(self, names: dict[str, str], role: str, checkpoint: str, played: Played) -> list[Rollout]:
        """Episodes as rows; `names`: task, training_set and run as the experiment calls them."""
        return [
            Rollout.model_validate(
                names
                | {
                    "cloud": self.trained.task_options.cloud,
                    "seed": self.trained.seed,
                    "checkpoint": checkpoint,
                    "test_asset": role,
                    "asset": asset.asset,
                    "dino_distance": asset.distance,
                    "episode": number,
                    "initial_state": episode.seed,
                    "success": episode.success,
                    "official_success": episode.official_success,
                    "steps": episode.steps,
                    "opened": round(episode.opened, 4),
                }
            )
            for number, (asset, episode) in enumerate(played)
        ]
