"""Command `rollout`: success of a policy on test assets and unseen ones, a row per episode (paper B.3, Table 3)."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Literal

from roomkin.stages.config.evaluation import RolloutOptions
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_options, read_rows
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.evaluation.choose import best_checkpoint
from roomkin.stages.evaluation.states import starts_of, write_rows
from roomkin.stages.evaluation.vector_env import Acting, PolicyVectorEnv, RolloutEpisode


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
    selection: tuple[Path, ...] = (),
    options: str = "",
    films: tuple[str, ...] = (),
    seed: int = 0,
    device: Literal["cpu", "cuda"] = "cpu",
) -> None:
    """Roll a policy out on the test assets and on the unseen assets of a split, with the task options that it was
    trained with and each asset shown as `options` say.

    Args:
        policy: folder that `training train` wrote.
        assets: those of the target (contract TaskAssets).
        library: library.json that they come from.
        target: what is opened, by its name in the experiment, for the rows.
        policy_name: name of the policy there, for the rows.
        training_set: name of the training set, for the rows.
        trained_roles: roles of the assets that it was trained on.
        run_name: name of the policy config, for the rows.
        out: rollouts.csv.
        selection: rollouts.csv of its selection rollouts, if there were some; `checkpoint: rollouts` goes by it.
        options: the `evaluation` section as JSON, or a JSON file.
        films: modules whose `RolloutFilms` film a success and a failure per test asset, e.g. of the package films.
        seed: of the initial states; the same for every policy that is to be compared.
        device: where the policy runs.
    """
    settings = read_options(RolloutOptions, options)
    rows: list[Rollout] = []
    # The twin's policy: one test serves twin and trained.
    played: dict[tuple[tuple[str, int], ...], list[RolloutEpisode]] = {}
    filmers = [import_module(name).RolloutFilms() for name in films]
    with PolicyVectorEnv(policy, assets, library, settings, device) as envs:
        tested = starts_of(envs.plan, assets, settings, trained_roles, seed)
        checkpoint = checkpoint_of(settings, selection)
        network = envs.network(checkpoint)
        acting = Acting(target, policy_name, training_set, run_name, envs.trained.seed, checkpoint)
        for test_asset, starts in tested.items():
            same = tuple((asset.asset, state) for asset, state in starts)
            if same not in played:
                played[same] = envs.episodes(network, starts, record=bool(filmers))
                for filmer in filmers:
                    filmer.take(played[same], test_asset)
            successes = sum(episode.success for episode in played[same])
            print(f"evaluation: {test_asset} {successes}/{len(starts)} succeeded", file=sys.stderr)
            rows += envs.rows(acting, test_asset, played[same])
    for filmer in filmers:
        filmer.write(out.parent, envs.options.control_frequency)
    write_rows(out, rows)


def checkpoint_of(settings: RolloutOptions, selection: tuple[Path, ...]) -> str:
    """The name of the checkpoint to test; `rollouts`: the one that did best in its selection rollouts."""
    if settings.checkpoint != "rollouts":
        return settings.checkpoint
    if len(selection) != 1:
        what = "is not one file; `checkpoint: rollouts` needs it."
        raise InputError("--selection", what, "run `evaluation selection-rollout`", code="E-SELECTION-MISSING")
    return best_checkpoint(read_rows(Rollout, selection[0])).checkpoint
