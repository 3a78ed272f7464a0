"""Command `selection-rollout`: a policy's checkpoints on the twin, from states that no test uses (paper B.3, B.4)."""

import sys
from pathlib import Path
from typing import Literal

from roomkin.stages.config.evaluation import SelectionOptions
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_options
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.evaluation.states import initial_states, write_rows
from roomkin.stages.evaluation.vector_env import Acting, PolicyVectorEnv


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
    """Roll the checkpoints of a policy out on the twin: they choose the checkpoint and the policy configs.

    Args:
        policy: folder that `training train` wrote.
        assets: those of the target (contract TaskAssets).
        library: library.json that they come from.
        target: what is opened, by its name in the experiment, for the rows.
        policy_name: name of the policy there, for the rows.
        training_set: name of the training set, for the rows.
        run_name: name of the policy config, for the rows.
        out: rollouts.csv.
        options: the `evaluation` section as JSON, or a JSON file.
        seed: of the initial states; the same for every policy that is to be compared.
        device: where the policy runs.
    """
    settings = read_options(SelectionOptions, options)
    rows: list[Rollout] = []
    with PolicyVectorEnv(policy, assets, library, settings, device) as envs:
        checkpoints: list[str] = [settings.checkpoint]
        if settings.checkpoint == "rollouts":
            checkpoints = envs.trained.checkpoints
        if not checkpoints:
            mend = "set `num_checkpoints` of its config, or `checkpoint: best`"
            raise InputError(policy, "has no kept checkpoints to choose from.", mend, code="E-POLICY-CHECKPOINTS")
        twin = envs.plan.find_asset("twin", assets)
        starts = [(twin, state) for state in initial_states("selection", seed, settings.selection_rollouts)]
        for name in checkpoints:
            played = envs.episodes(envs.network(name), starts)
            successes = sum(episode.success for episode in played)
            print(f"evaluation: {name} opens the twin {successes}/{len(starts)} times", file=sys.stderr)
            acting = Acting(target, policy_name, training_set, run_name, envs.trained.seed, name)
            rows += envs.rows(acting, "twin", played)
    write_rows(out, rows)
