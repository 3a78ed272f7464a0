"""Rows of the tables: policies of one method each. What differs in more than its seed is never averaged.

A row of the experiment with several hyper-parameter sets is a row of the tables for each set: the first has the row's
name, another is `<row>/<set>`. Sets are one row only where trials chose the best of them, as the paper does (B.4).
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from stages.config.tables import MethodTables, PolicyRow, PolicyTables
from stages.contracts.errors import InputError
from stages.contracts.policies import Rollout
from stages.tables.order import SKILL, title
from stages.tables.rows import ONE_TEST, read_rows

Kinds = Mapping[str, str]  # row of the tables -> its policies in words


def name_of(row: str, run: str, first: str) -> str:
    """The row of the tables for a hyper-parameter set of a row of the experiment; `first`: the row's first set."""
    return row if run == first else f"{row}/{run}"


def row_of(name: str) -> str:
    """The row of the experiment that a row of the tables is of."""
    return name.partition("/")[0]


def methods(rows: Mapping[str, PolicyRow]) -> dict[str, list[str]]:
    """Rows of the tables -> their hyper-parameter sets: one, or all those that trials choose from."""
    found: dict[str, list[str]] = {}
    for name, row in rows.items():
        found |= {name: row.runs} if row.best else {name_of(name, run, row.runs[0]): [run] for run in row.runs}
    return found


def by_method(rollouts: pd.DataFrame, rows: Mapping[str, PolicyRow]) -> pd.DataFrame:
    """The rollouts with `task` as a row of the tables; of rows that are not known, the set that comes first is first.

    Where more sets were rolled out than trials choose, some were not chosen: then all stand alone.

    Raises:
        InputError: a policy was rolled out at several checkpoints, which would count as several runs.
    """
    _check_checkpoints(rollouts)
    names = rollouts["task"].copy()
    for task, part in rollouts[rollouts["training_set"] != SKILL].groupby("task", sort=False):
        row = rows.get(str(task), PolicyRow())
        if row.best and part.groupby("training_set")["run"].nunique().max() <= row.best:
            continue
        first = next(iter(row.runs), part["run"].iloc[0])
        names[part.index] = [name_of(str(task), run, first) for run in part["run"]]
    return rollouts.assign(task=names)


def _check_checkpoints(rollouts: pd.DataFrame) -> None:
    policy = ["task", "training_set", "run", "seed", *(["condition"] if "condition" in rollouts else [])]
    for key, checkpoints in rollouts.groupby(policy)["checkpoint"]:
        if checkpoints.nunique() > 1:
            what = f"hold checkpoints {' and '.join(sorted(set(checkpoints)))} of the policy {'/'.join(map(str, key))}."
            raise InputError("--rollouts", what, "give those of one checkpoint", "E-CHECKPOINTS-MIXED")


def read_rollouts(paths: Sequence[Path], options: MethodTables) -> pd.DataFrame:
    """All rows of some files of `Rollout`, with `task` as `by_method` has it."""
    return by_method(read_rows(Rollout, paths, ONE_TEST), options.rows)


def kinds_of(options: PolicyTables) -> dict[str, str]:
    """Rows of the tables -> what their policies are, in words."""
    found = {}
    for name, runs in methods(options.rows).items():
        best = options.rows[name].best if name in options.rows else None
        sets = f"best {best} of {', '.join(runs)}" if best else runs[0]
        text = options.kinds.get(runs[0], sets)
        found[name] = text if text == sets else f"{text} ({sets})"
    return found


def kind(name: str, known: Kinds) -> str:
    """What the policies of a row of the tables are, in words; its name where that is not known."""
    return known.get(name) or name.partition("/")[2] or title(name)
