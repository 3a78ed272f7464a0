"""Policies of one method each, over one target or a pool of several.

What differs in more than its seed is never averaged, but where rollouts chose (B.4).
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import pandas as pd

from roomkin.stages.config.tables import MethodTables, PolicyTables
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.tables.order import SKILL
from roomkin.stages.tables.rows import ONE_TEST, read_rows

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
            raise InputError(
                "--rollouts", what, "give those that were selected, or make each a policy", code="E-RUNS-MIXED"
            )


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
