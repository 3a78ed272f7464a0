"""Rows of the tables whose policies do one task, by one method, on the objects of several rooms, as one row."""

from collections import Counter

import pandas as pd

from stages.config.model import Config
from stages.config.policy_rows import policy_rows
from stages.tables.methods import methods, row_of
from stages.tables.order import SKILL, ending

RUN = ["task", "training_set", "run", "seed"]


def pools(config: Config) -> dict[str, str]:
    """Row of the tables (`methods`) -> the pooled row: its task, and what is different about its cloud and its name.

    Rows stay alone where no other row does the same in another room: the task, its options, the demonstrations'
    number and the policies' hyper-parameters.
    """
    experiment, sets = config.experiment, methods(policy_rows(config))
    alike: dict[str, list[str]] = {}
    for name, runs in sets.items():
        plan, options = experiment.plan(row_of(name)), config.task_of(row_of(name))
        alike.setdefault(repr((plan.task, options, plan.episodes, runs)), []).append(name)
    names, taken = {name: name for name in sets}, set(sets)
    for rows in alike.values():
        if len(rows) == 1 or len({experiment.source(row_of(name)) for name in rows}) < len(rows):
            continue
        first = row_of(rows[0])
        cloud = "_object" if config.task_of(first).cloud == "object" else ""
        name = f"{experiment.plan(first).task}{cloud}{ending(first)}"
        name = name if name not in taken - set(rows) else f"{name}/{'+'.join(sets[rows[0]])}"
        names |= dict.fromkeys(rows, name)
        taken.add(name)
    return names


def pooled(rollouts: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The rollouts (as `by_method` has them) with `task` and `assets_of` as `pools` says.

    An asset in another room's box is another asset; its family stays one, so that a resample takes all of it or
    nothing. Policies of one training seed, one per room, are one run; runs that lack a room are left out.
    """
    names = pools(config)
    found = rollouts.assign(task=_of(rollouts["task"], names), assets_of=_of(rollouts["assets_of"], names))
    owners = found.groupby("task")["assets_of"].transform("nunique")
    found["assets_of"] = found["assets_of"].where(owners == 1, found["task"])
    several = found["task"] != rollouts["task"]
    found["asset"] = rollouts["asset"].where(~several, rollouts["assets_of"] + "/" + rollouts["asset"])
    found["checkpoint"] = rollouts["checkpoint"].where(~several, "each its own")
    rooms = found.assign(row=rollouts["task"]).groupby(RUN)["row"].transform("nunique")
    asked = found["task"].map(Counter(names.values())).fillna(1)
    return found[(rooms == asked) | (found["training_set"] == SKILL)]


def _of(names: pd.Series, pools: dict[str, str]) -> pd.Series:
    return names.map(lambda name: pools.get(name, name))
