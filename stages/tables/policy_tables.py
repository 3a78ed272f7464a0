"""Policies of one method each, Table 3 as text, and what stands below tables of policies.

What differs in more than its seed is never averaged, but where rollouts chose (B.4).
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from roomkin.stages.config.evaluation import MethodTables, PolicyTables, TablesConfig
from roomkin.stages.contracts.errors import InputError, count
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.plugins import shorten_name
from roomkin.stages.tables.rows import CELL, CLOUDS, ONE_TEST, SKILL, read_rows, records, set_key, target_title, title
from roomkin.stages.tables.table2 import format_confidence
from roomkin.stages.tables.text import NOT_RUN, TextTable, cell, interval, number, percent, read_notes

Kinds = Mapping[str, str]  # policy -> what it is, in words


def read_rollouts(paths: Sequence[Path], options: MethodTables) -> pd.DataFrame:
    """All rows of some files of `Rollout`.

    Raises:
        InputError: rows of a policy are of several checkpoints, or of more runs than selection rollouts choose.
    """
    rollouts = read_rows(Rollout, paths, ONE_TEST)
    check_methods(rollouts, options)
    return rollouts


def read_pooled(paths: Sequence[Path], options: MethodTables) -> pd.DataFrame:
    """`read_rollouts`, with the pools of the run in the place of their targets."""
    return pool_rollouts(read_rollouts(paths, options), options)


def check_methods(rollouts: pd.DataFrame, options: MethodTables) -> None:
    """Refuse rows that would count as several runs of a method and are not.

    Raises:
        InputError: rows of a policy are of several checkpoints, or of more runs than selection rollouts choose.
    """
    policy = ["target", "policy", "training_set", "run", "seed"]
    for key, checkpoints in rollouts.groupby(policy)["checkpoint"]:
        if checkpoints.nunique() > 1:
            what = f"hold checkpoints {' and '.join(sorted(set(checkpoints)))} of the policy {'/'.join(map(str, key))}."
            raise InputError("--rollouts", what, "give those of one checkpoint", code="E-CHECKPOINTS-MIXED")
    for (target, name, training_set), runs in rollouts.groupby(policy[:3])["run"]:
        best = options.policies[name].best if name in options.policies else None
        if runs.nunique() > (best or 1):
            what = f"hold the runs {' and '.join(sorted(set(runs)))} of {target}/{name}/{training_set}."
            fix = "give those that were selected, or make each a policy"
            raise InputError("--rollouts", what, fix, code="E-RUNS-MIXED")


def kinds_of(options: PolicyTables) -> dict[str, str]:
    """Policy -> what it is, in words: its kind and its name, or the configs that were chosen from."""
    found = options.policies.items()
    best = {name: f"best {about.best} of settings {', '.join(about.configs)}" for name, about in found if about.best}
    return {name: name if kind == name else f"{kind} ({best.get(name, name)})" for name, kind in options.kinds.items()}


def join_published(published: pd.DataFrame, ours: pd.DataFrame, options: PolicyTables) -> pd.DataFrame:
    """Rows of the paper with `target` and `policy`: those of ours that they stand beside.

    These are, of every task, the first target whose clouds show the link that is meant, and there the first policy of
    the paper's kind. Where there is none, the paper's rows stand alone: `target` is the task, `policy` empty.

    Args:
        ours: has the columns target, task, policy, cloud.
    """
    others = {*options.kinds, SKILL} - {*options.papers}
    alike = (ours["cloud"] == "target_link") & ~ours["policy"].isin(others)
    first = ours.loc[alike, ["task", "target", "policy"]].drop_duplicates("task")
    found = published.merge(first, "left", on="task")
    return found.assign(target=found["target"].fillna(found["task"]), policy=found["policy"].fillna(""))


RUN = ["target", "policy", "training_set", "run", "seed"]


def pool_of(options: MethodTables, targets: Iterable[str]) -> dict[str, str]:
    """Target -> its pool; itself where it is in none."""
    return {name: name for name in targets} | {name: pool for pool, names in options.pools.items() for name in names}


def pool_rollouts(rollouts: pd.DataFrame, options: MethodTables) -> pd.DataFrame:
    """The rollouts with pools in the place of their targets.

    An asset in another room's box is another asset; its family stays one, so that a resample takes all of it or
    nothing. Policies of one training seed, one per target, are one run; runs that lack a target are left out.
    """
    pools = pool_of(options, rollouts["target"].unique())
    found = rollouts.assign(target=rollouts["target"].map(pools))
    several = found["target"] != rollouts["target"]
    found["asset"] = rollouts["asset"].where(~several, rollouts["target"] + "/" + rollouts["asset"])
    found["checkpoint"] = rollouts["checkpoint"].where(~several, "each its own")
    there = found.assign(row=rollouts["target"]).groupby(RUN)["row"].transform("nunique")
    asked = [_count_targets(options, *key) for key in zip(found["target"], found["policy"], strict=True)]
    return found[(there >= asked) | (found["training_set"] == SKILL)]


def _count_targets(options: MethodTables, target: str, policy: str) -> int:
    """How many targets of a pool a policy opens; 1 of what is no pool."""
    names, about = options.pools.get(target, [target]), options.policies.get(policy)
    return len(names) if about is None else len([name for name in names if name in about.targets])


def policy_notes(options: PolicyTables) -> list[str]:
    """The notes of a run, as far as its options are known."""
    kinds, sensing = kinds_of(options), options.sensing
    pooled = [kinds.get(name, name) for name, about in options.policies.items() if (about.best or 0) > 1]
    simulator = shorten_name(sensing.simulator) if sensing else ""
    return read_notes("policies", pooled=pooled, sensing=sensing, starts=options.starts, simulator=simulator)


def _format_rate(row: dict[str, Any]) -> tuple[str, str]:
    """Value and remark of a cell of Table 3."""
    counts = f"{interval(row)} {row['successes']}/{row['episodes']}, {count(row['runs'], 'run')}"
    official = f"official {percent(row['official_successes'] / row['episodes'])}"
    steps = "" if pd.isna(row["steps"]) else f", {row['steps']:.0f} steps"
    return percent(row["mean"], row["std"]), f"{counts}, {official}{steps}"


def policies_table(
    table: pd.DataFrame,
    published: pd.DataFrame,
    options: TablesConfig,
    kinds: Kinds | None = None,
    notes: Sequence[str] = (),
) -> TextTable:
    """Table 3, laid out as in the paper: a row per test asset, a column per set.

    Args:
        table: as `table3.cells` gives.
        published: the paper's, beside ours (`methods.join_published`).
    """
    ours, theirs = ({tuple(row[name] for name in CELL): row for row in records(one)} for one in (table, published))
    every = theirs | ours
    sets, order = sorted({key[3] for key in every}, key=set_key), [key[:2] for key in (*ours, *theirs)]
    rows = []
    for of in sorted({key[:3] for key in every}, key=lambda of: (order.index(of[:2]), set_key(of[2]))):
        target, policy, asset = of
        ran = {name: ours[*of, name] for name in sets if (*of, name) in ours}
        first = next(iter(ran.values()), None)
        task = next(row["task"] for key, row in every.items() if key[:2] == of[:2])
        about = [(kinds or {}).get(policy, policy), CLOUDS[first["cloud"]]] if first else []
        line = [cell(target_title(target, task), "\n".join(about)), title(asset)]
        line.append(number(first["feature_distance"], 2) if first else "")
        for name in sets:
            paper = theirs.get((*of, name))
            missing = (NOT_RUN if paper or ran else "", "")
            value, remark = _format_rate(ran[name]) if name in ran else missing
            line.append(cell(value, remark, percent(paper["mean"], paper["std"]) if paper else ""))
        rows.append(line)
    return TextTable(
        name="table3",
        caption="Table 3: success of policies by training set (columns) and test asset (rows).",
        columns=["Task", "Test asset", "Distance", *(title(name) for name in sets)],
        rows=rows,
        headers=2,
        notes=[*read_notes("table3", confidence=format_confidence(options)), *notes],
    )
