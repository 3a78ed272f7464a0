"""Verb `rollout`: success of one policy on every test asset, one row per episode (paper B.3, Table 3)."""

import sys
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from stages.config.evaluation import RolloutOptions
from stages.contracts.errors import InputError
from stages.contracts.files import atomic, read_options, read_rows
from stages.contracts.policies import Rollout, TaskAsset, TaskAssets
from stages.evaluation.arena import FIRST_STATE, Arena, Played, initial_states
from stages.evaluation.choose import best_checkpoint
from stages.evaluation.film import Reel, strip
from stages.evaluation.rows import write_rows
from stages.simulation.films import write_films

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
    trial: tuple[Path, ...] = (),
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
        trial: rollouts.csv of the policy's trial, if there was one; `checkpoint: rollouts` goes by it.
        options: the `evaluation` section as JSON, or a JSON file.
        seed: of the initial states; the same for every policy that is to be compared.
        device: where the policy runs.
    """
    settings = read_options(RolloutOptions, options)
    arena = Arena(policy, assets, library, settings, device)
    tested = {role: players(arena.plan, role, trained_roles, assets) for role in settings.test_assets}
    checkpoint: str = settings.checkpoint
    if checkpoint == "rollouts":
        if len(trial) != 1:
            raise InputError("--trial", "is not one file; `checkpoint: rollouts` needs it.", "run `evaluation trial`")
        checkpoint = best_checkpoint(read_rows(Rollout, trial[0])).checkpoint
    network = arena.network(checkpoint)
    states = initial_states(FIRST_STATE, seed, settings.rollouts)
    names = {"task": task_name, "training_set": training_set, "run": run_name}
    rows: list[Rollout] = []
    reel = Reel(settings.film_frames)
    played: dict[tuple[str, ...], Played] = {}
    for role, playing in tested.items():
        same = tuple(
            asset.asset for asset in playing
        )  # the twin's policy was trained on the twin: one test serves both
        episodes = played[same] = played.get(same) or arena.test(network, playing, states, reel)
        successes = sum(episode.success for _, episode in episodes)
        print(f"evaluation: {role} {successes}/{len(episodes)} succeeded", file=sys.stderr)
        rows += arena.rows(names, role, checkpoint, episodes)
    frequency = arena.trained.task_options.control_frequency
    write_films(out.parent / "films", [(item.film, item.pictures) for item in reel.films], frequency)
    write_png(out.parent / "film.png", np.concatenate([strip(item) for item in reel.films]))
    write_rows(out, rows)


def players(plan: TaskAssets, role: str, trained_roles: tuple[str, ...], where: Path) -> list[TaskAsset]:
    """The assets that stand for a test role: one, or for `trained` all that the policy was trained on."""
    if role != TRAINED:
        return [plan.playing(role, where)]
    assets = [asset for name in trained_roles for asset in plan.behind(name, where)]
    return [asset.model_copy(update={"role": TRAINED}) for asset in assets]


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write an RGB picture atomically."""
    with atomic(path) as temporary:
        cv2.imwrite(str(temporary), picture[..., ::-1])
