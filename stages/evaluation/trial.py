"""Verb `trial`: success of a policy's checkpoints on the twin, from states that no test uses (paper B.3, B.4)."""

import sys
from pathlib import Path
from typing import Literal

from stages.config.evaluation import TrialOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_options
from stages.contracts.policies import Rollout
from stages.evaluation.arena import Acting, PolicyArena
from stages.evaluation.rows import write_rows
from stages.evaluation.states import initial_states


def run(
    *,
    policy: Path,
    assets: Path,
    library: Path,
    target: str,
    policy_name: str,
    training_set: str,
    run_name: str,
    out: Path,
    options: str = "",
    seed: int = 0,
    device: Literal["cpu", "cuda"] = "cpu",
) -> None:
    """Roll the checkpoints of a policy out on the twin: they choose the checkpoint and the hyper-parameter sets.

    Args:
        policy: folder that `training train` wrote.
        assets: those of the target (contract TaskAssets).
        library: library.json that they come from.
        target: what is opened, by its name in the experiment, for the rows.
        policy_name: name of the policy there, for the rows.
        training_set: name of the training set, for the rows.
        run_name: name of the hyper-parameter set, for the rows.
        out: rollouts.csv.
        options: the `evaluation` section as JSON, or a JSON file.
        seed: of the initial states; the same for every policy that is to be compared.
        device: where the policy runs.
    """
    settings = read_options(TrialOptions, options)
    rows: list[Rollout] = []
    with PolicyArena(policy, assets, library, settings, device) as arena:
        checkpoints: list[str] = [settings.checkpoint]
        if settings.checkpoint == "rollouts":
            checkpoints = arena.trained.checkpoints
        if not checkpoints:
            mend = "set training `keep`, or `checkpoint: best`"
            raise InputError(policy, "has no kept checkpoints to choose from.", mend, code="E-POLICY-CHECKPOINTS")
        twin = arena.plan.find_asset("twin", assets)
        starts = [(twin, state) for state in initial_states("trial", seed, settings.selection_rollouts)]
        for name in checkpoints:
            played = arena.episodes(arena.network(name), starts)
            successes = sum(episode.success for episode in played)
            print(f"evaluation: {name} opens the twin {successes}/{len(starts)} times", file=sys.stderr)
            acting = Acting(target, policy_name, training_set, run_name, arena.trained.seed, name)
            rows += arena.rows(acting, "twin", played)
    write_rows(out, rows)
