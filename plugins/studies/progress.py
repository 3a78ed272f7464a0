"""How far a study has come: policies that were rolled out, of those that it asks for."""

from itertools import product
from pathlib import Path

import pandas as pd

from roomkin.stages.config.evaluation import USUAL
from roomkin.stages.config.model import Config
from roomkin.stages.config.policy_kinds import policy_tables
from roomkin.stages.config.targets import Cell
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.policies import ChosenRuns
from roomkin.stages.tables.markup import Table
from roomkin.stages.tables.order import row_title, set_key, title
from roomkin.stages.tables.pooling import pool_of
from roomkin.stages.tables.text import NOT_RUN

KEYS = ["target", "policy", "condition", "training_set"]


def policy_file(results: Path, condition: str, cell: Cell, run: str, seed: int) -> Path:
    """The files of a policy's rollouts; `condition`: empty for the usual one."""
    folder = results / "evaluation" / (f"conditions/{condition}" if condition else "policies")
    return folder / Path(*cell) / f"{run}/seed_{seed}/rollouts.csv"


def list_counting_runs(config: Config, results: Path, cell: Cell) -> list[str]:
    """The policy configs that count: where selection rollouts chose, those that they chose."""
    path = results / "evaluation/selection" / Path(*cell) / "chosen.json"
    chose = config.experiment.needs_choice(cell.policy) and path.is_file()
    return read_json(ChosenRuns, path).runs if chose else config.experiment.plan(cell.policy).configs


def progress_table(config: Config, results: Path) -> Table:
    """A row per target (or pool), policy and condition, a column per training set: policies tested on all targets."""
    experiment = config.experiment
    pools = pool_of(policy_tables(config), experiment.targets)
    tasks = {pools[name]: experiment.task(name) for name in experiment.targets}
    found = [
        (pools[cell.target], cell.policy, condition or USUAL, cell.training_set, run, seed,
         policy_file(results, condition, cell, run, seed).is_file())
        for condition in ("", *config.evaluation.conditions)
        for cell in experiment.cells
        for run, seed in product(list_counting_runs(config, results, cell), experiment.plan(cell.policy).seeds)
    ]  # fmt: skip
    policies = pd.DataFrame(found, columns=[*KEYS, "run", "seed", "there"])
    whole = policies.groupby([*KEYS, "run", "seed"], sort=False)["there"].all()
    cells = whole.groupby(KEYS, sort=False).agg(done="sum", asked="size").reset_index()
    sets = sorted(cells["training_set"].unique(), key=set_key)
    rows, tested = [], {USUAL}
    for (target, policy, condition), part in cells.groupby(KEYS[:3], sort=False):
        if condition == USUAL or part["done"].any():
            tested.add(str(condition))
            texts = {
                name: f"{done} of {asked}" if done else NOT_RUN
                for name, done, asked in zip(part["training_set"], part["done"], part["asked"], strict=True)
            }
            name = row_title({"target": target, "task": tasks[str(target)], "policy": policy})
            rows.append([name, title(str(condition)), *(texts.get(each, "") for each in sets)])
    lacking = [title(name) for name in config.evaluation.conditions if name not in tested]
    return Table(
        "progress",
        "Policies that were rolled out, of those that are asked for.",
        ["Policy", "Condition", *map(title, sets)],
        rows,
        headers=2,
        notes=[f"Conditions without any rollout: {', '.join(lacking)}."] if lacking else [],
    )
