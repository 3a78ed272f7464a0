"""Verb `rollout`: success of one policy on every test asset, one row per episode (paper B.3, Table 3)."""

import sys
from functools import cached_property
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import pandas as pd
import torch

from stages.config.evaluation import EvaluationConfig
from stages.contracts.errors import InputError
from stages.contracts.files import atomic, read_json, read_options
from stages.contracts.library import Library
from stages.contracts.policies import Rollout, TaskAsset, TaskAssets
from stages.contracts.policy_folder import read_config
from stages.contracts.trained import TrainedPolicy
from stages.evaluation.episodes import RolloutEpisode, roll_out
from stages.evaluation.film import Filmed, strip, take
from stages.policies import TrainablePolicy
from stages.policies.checkpoint import load_policy
from stages.simulation.films import write_films
from stages.simulation.studio import Studio
from stages.tasks.api import TaskEnv, make_task

FIRST_STATE = 2**31  # demonstrations use seeds below: no policy is tested on a state that it was shown
SELECTION_STATE = FIRST_STATE + 2**30  # states that choose a checkpoint are not those that it is judged by

TRAINED = "trained"  # test role of the assets that a policy was trained on


def run(
    *,
    policy: Path,
    assets: Path,
    library: Path,
    task_name: str,
    training_set: str,
    trained_roles: tuple[str, ...],
    run_name: str,
    out: Path,
    options: str = "",
    seed: int = 0,
    device: Literal["cpu", "cuda"] = "cpu",
) -> None:
    """Roll a policy out on the test assets, in the environment of its demonstrations.

    Args:
        policy: folder that `training train` wrote.
        assets: the experiment's assets (contract TaskAssets).
        library: library.json that they come from.
        task_name: name of the task's row in the experiment, for the rows.
        training_set: name of the training set, for the rows.
        trained_roles: roles of the assets that it was trained on.
        run_name: name of the hyper-parameter set, for the rows.
        out: rollouts.csv; film.png and films/ lie beside it.
        options: the `evaluation` section as JSON, or a JSON file.
        seed: of the initial states; the same for every policy that is to be compared.
        device: where the policy runs.
    """
    settings = read_options(EvaluationConfig, options)
    trained = read_config(policy)
    plan = read_json(TaskAssets, assets)
    if plan.task != trained.task:
        raise InputError(policy, f"was trained on the task '{trained.task}', {assets} is for '{plan.task}'.")
    torch.set_num_threads(1)
    arena = Arena(trained, settings, library, device)
    tested = {role: players(plan, role, trained_roles, assets) for role in settings.test_assets}
    checkpoint: str = settings.checkpoint
    if checkpoint == "rollouts":
        checkpoint = arena.most_successful(policy, plan.playing("twin", assets), seed)
    network = load_policy(policy, checkpoint, device)
    rows: list[Rollout] = []
    films: list[Filmed] = []
    states = [FIRST_STATE + seed * 10_000 + i for i in range(settings.rollouts)]
    played: dict[tuple[str, ...], list[tuple[TaskAsset, RolloutEpisode]]] = {}
    for role, playing in tested.items():
        same = tuple(
            asset.asset for asset in playing
        )  # the twin's policy was trained on the twin: one test serves both
        episodes = played[same] = played.get(same) or arena.test(network, playing, states, films)
        successes = sum(episode.success for _, episode in episodes)
        print(f"evaluation: {role} {successes}/{len(episodes)} opened", file=sys.stderr)
        rows += [
            Rollout(
                task=task_name,
                training_set=training_set,
                run=run_name,
                seed=trained.seed,
                checkpoint=checkpoint,
                test_asset=role,
                asset=asset.asset,
                dino_distance=asset.distance,
                episode=number,
                initial_state=episode.seed,
                success=episode.success,
                steps=episode.steps,
                opened=round(episode.opened, 4),
            )
            for number, (asset, episode) in enumerate(episodes)
        ]
    frequency = trained.task_options.control_frequency
    write_films(out.parent / "films", [(item.film, item.pictures) for item in films], frequency)
    write_png(out.parent / "film.png", np.concatenate([strip(item) for item in films]))
    with atomic(out) as temporary:
        pd.DataFrame([row.model_dump() for row in rows]).to_csv(temporary, index=False)


def players(plan: TaskAssets, role: str, trained_roles: tuple[str, ...], where: Path) -> list[TaskAsset]:
    """The assets that stand for a test role: one, or for `trained` all that the policy was trained on."""
    if role != TRAINED:
        return [plan.playing(role, where)]
    assets = [asset for name in trained_roles for asset in plan.behind(name, where)]
    return [asset.model_copy(update={"role": TRAINED}) for asset in assets]


class Arena:
    """Test assets in the environment that a policy was trained for."""

    def __init__(self, trained: TrainedPolicy, settings: EvaluationConfig, library: Path, device: str) -> None:
        self.trained, self.settings, self.device, self.library = trained, settings, device, library
        entries = read_json(Library, library).assets
        self.folders = {entry.id: library.parent / entry.folder for entry in entries}

    def test(
        self, network: TrainablePolicy, assets: list[TaskAsset], states: list[int], films: list[Filmed]
    ) -> list[tuple[TaskAsset, RolloutEpisode]]:
        """One episode per initial state, the assets of a role taking turns; those of the first one are filmed."""
        played: dict[int, tuple[TaskAsset, RolloutEpisode]] = {}
        for turn, asset in enumerate(assets[: len(states)]):
            shared = states[turn :: len(assets)]
            episodes = self.episodes(network, asset, shared, None if turn else films)
            played |= {state: (asset, episode) for state, episode in zip(shared, episodes, strict=True)}
        return [played[state] for state in states]

    def episodes(
        self, network: TrainablePolicy, asset: TaskAsset, states: list[int], films: list[Filmed] | None = None
    ) -> list[RolloutEpisode]:
        """One episode per initial state; a success and a failure are filmed and put into `films` if that is given."""
        tasks = [self.task(asset) for _ in range(min(self.settings.envs, len(states)))]
        actor = network.actor(len(tasks), self.settings.action)
        try:
            episodes = roll_out(tasks, actor, states, record=films is not None)
            if films is not None:
                films += take(self.studio, episodes, asset.role, asset.asset, self.settings.film_frames)
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

    def most_successful(self, folder: Path, twin: TaskAsset, seed: int) -> str:
        """The kept checkpoint that opens the twin most often; of equals the later one."""
        names = self.trained.checkpoints
        if not names:
            raise InputError(
                folder, "has no kept checkpoints to choose from.", "set training `keep`, or `checkpoint: best`"
            )
        states = [SELECTION_STATE + seed * 10_000 + i for i in range(self.settings.selection_rollouts)]
        scores = {}
        for name in names:
            episodes = self.episodes(load_policy(folder, name, self.device), twin, states)
            scores[name] = sum(episode.success for episode in episodes)
            print(f"evaluation: {name} opens the twin {scores[name]}/{len(states)} times", file=sys.stderr)
        return max(reversed(names), key=scores.__getitem__)


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write an RGB picture atomically."""
    with atomic(path) as temporary:
        cv2.imwrite(str(temporary), picture[..., ::-1])
