"""Verb `rollout`: success of one policy on roles and on unseen assets, one row per episode (paper B.3, Table 3)."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Literal

from stages.config.evaluation import RolloutOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_options, read_rows
from stages.contracts.policies import Rollout
from stages.evaluation.arena import Acting, PolicyArena
from stages.evaluation.choose import best_checkpoint
from stages.evaluation.episodes import RolloutEpisode
from stages.evaluation.rows import write_rows
from stages.evaluation.states import starts_of


def run(
    *,
    policy: Path,
    assets: Path,
    library: Path,
    target: str,
    policy_name: str,
    training_set: str,
    trained_roles: tuple[str, ...],
    run_name: str,
    out: Path,
    trial: tuple[Path, ...] = (),
    options: str = "",
    films: tuple[str, ...] = (),
    seed: int = 0,
    device: Literal["cpu", "cuda"] = "cpu",
) -> None:
    """Roll a policy out on the test roles and on the unseen assets of a split, with the task options that it was
    trained with and each asset shown as `options` say.

    Args:
        policy: folder that `training train` wrote.
        assets: those of the target (contract TaskAssets).
        library: library.json that they come from.
        target: what is opened, by its name in the experiment, for the rows.
        policy_name: name of the policy there, for the rows.
        training_set: name of the training set, for the rows.
        trained_roles: roles of the assets that it was trained on.
        run_name: name of the hyper-parameter set, for the rows.
        out: rollouts.csv.
        trial: rollouts.csv of the policy's trial, if there was one; `checkpoint: rollouts` goes by it.
        options: the `evaluation` section as JSON, or a JSON file.
        films: modules whose `RolloutFilms` film a success and a failure per test asset, e.g. plugins.films.rollouts.
        seed: of the initial states; the same for every policy that is to be compared.
        device: where the policy runs.
    """
    settings = read_options(RolloutOptions, options)
    rows: list[Rollout] = []
    played: dict[
        tuple[tuple[str, int], ...], list[RolloutEpisode]
    ] = {}  # the twin's policy: one test serves twin and trained
    filmers = [import_module(name).RolloutFilms() for name in films]
    with PolicyArena(policy, assets, library, settings, device) as arena:
        tested = starts_of(arena.plan, assets, settings, trained_roles, seed)
        checkpoint = checkpoint_of(settings, trial)
        network = arena.network(checkpoint)
        acting = Acting(target, policy_name, training_set, run_name, arena.trained.seed, checkpoint)
        for role, starts in tested.items():
            same = tuple((asset.asset, state) for asset, state in starts)
            if same not in played:
                played[same] = arena.episodes(network, starts, record=bool(filmers))
                for filmer in filmers:
                    filmer.take(played[same], role)
            successes = sum(episode.success for episode in played[same])
            print(f"evaluation: {role} {successes}/{len(starts)} succeeded", file=sys.stderr)
            rows += arena.rows(acting, role, played[same])
    for filmer in filmers:
        filmer.write(out.parent, arena.options.control_frequency)
    write_rows(out, rows)


def checkpoint_of(settings: RolloutOptions, trial: tuple[Path, ...]) -> str:
    """The name of the checkpoint to test; `rollouts`: the one that did best in the policy's trial."""
    if settings.checkpoint != "rollouts":
        return settings.checkpoint
    if len(trial) != 1:
        what = "is not one file; `checkpoint: rollouts` needs it."
        raise InputError("--trial", what, "run `evaluation trial`", code="E-TRIAL-MISSING")
    return best_checkpoint(read_rows(Rollout, trial[0])).checkpoint
