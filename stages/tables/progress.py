"""How far a study has come: policies that were rolled out, of those that it asks for."""

from itertools import product
from pathlib import Path

import pandas as pd

from stages.config.model import Config
from stages.config.policy_rows import policy_rows
from stages.contracts.files import read_json
from stages.contracts.policies import ChosenRuns
from stages.tables.conditions import USUAL
from stages.tables.markup import Table
from stages.tables.methods import methods, row_of
from stages.tables.order import set_key, title
from stages.tables.pooling import pools
from stages.tables.text import NOT_RUN

CELL = ["task", "condition", "training_set"]


def policy_file(results: Path, condition: str, task: str, training_set: str, run: str, seed: int) -> Path:
    """Where the rollouts of a policy lie; `condition`: empty for the usual one."""
    folder = results / "evaluation" / (f"conditions/{condition}" if condition else "policies")
    return folder / f"{task}/{training_set}/{run}/seed_{seed}/rollouts.csv"


def runs_that_count(config: Config, results: Path, task: str, training_set: str) -> list[str]:
    """The hyper-parameter sets that count: where trials chose, those that they chose."""
    path = results / f"evaluation/trials/{task}/{training_set}/chosen.json"
    chose = config.experiment.chooses(task) and path.is_file()
    return read_json(ChosenRuns, path).runs if chose else config.experiment.plan(task).runs


def progress_table(config: Config, results: Path) -> Table:
    """A row per task and condition, a column per training set: policies that met all rooms of the task."""
    names, sets_of = pools(config), methods(policy_rows(config))
    found = [
        (
            pool,
            condition or USUAL,
            name,
            run,
            seed,
            policy_file(results, condition, row_of(row), name, run, seed).is_file(),
        )
        for condition in ("", *config.evaluation.conditions)
        for row, pool in names.items()
        for plan in (config.experiment.plan(row_of(row)),)
        for name in plan.training_sets
        for run, seed in product(sets_of[row], plan.seeds)
        if run in runs_that_count(config, results, row_of(row), name)
    ]
    policies = pd.DataFrame(found, columns=[*CELL, "run", "seed", "there"])
    whole = policies.groupby([*CELL, "run", "seed"], sort=False)["there"].all()
    cells = whole.groupby(CELL, sort=False).agg(done="sum", asked="size").reset_index()
    sets = sorted(cells["training_set"].unique(), key=set_key)
    rows, met = [], {USUAL}
    for (task, condition), part in cells.groupby(["task", "condition"], sort=False):
        if condition == USUAL or part["done"].any():
            met.add(str(condition))
            texts = {
                name: f"{done} of {asked}" if done else NOT_RUN
                for name, done, asked in zip(part["training_set"], part["done"], part["asked"], strict=True)
            }
            rows.append([title(str(task)), title(str(condition)), *(texts.get(name, "") for name in sets)])
    lacking = [title(name) for name in config.evaluation.conditions if name not in met]
    return Table(
        "progress",
        "Policies that were rolled out, of those that are asked for.",
        ["Task", "Condition", *map(title, sets)],
        rows,
        headers=2,
        notes=[f"Conditions that no policy has met: {', '.join(lacking)}."] if lacking else [],
    )
