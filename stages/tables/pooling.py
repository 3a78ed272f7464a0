"""Rows of the experiment that do one task on the objects of several rooms, as one row."""

from collections import Counter

import pandas as pd

from stages.config.model import Config
from stages.tables.order import SKILL, ending

RUN = ["task", "training_set", "run", "seed"]


def pools(config: Config) -> dict[str, str]:
    """Row of the experiment -> the pooled row: its task, and what is different about its cloud and its policies.

    Rows stay alone where no other row does the same.
    """
    names = {}
    for row in config.experiment.tasks:
        plan = config.experiment.plan(row)
        cloud = "_object" if config.task_of(row).cloud == "object" else ""
        names[row] = f"{plan.task}{cloud}{ending(row)}"
    rows = Counter(names.values())
    return {row: name if rows[name] > 1 else row for row, name in names.items()}


def pooled(rollouts: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The rollouts with `task` and `assets_of` as `pools` says.

    An asset in another room's box is another asset; its family stays one, so that a resample takes all of it or
    nothing. Policies of one training seed, one per room, are one run; runs that lack a room are left out.
    """
    names = pools(config)
    found = rollouts.assign(task=rollouts["task"].map(names), assets_of=rollouts["assets_of"].map(names))
    several = found["task"] != rollouts["task"]
    found["asset"] = rollouts["asset"].where(~several, rollouts["assets_of"] + "/" + rollouts["asset"])
    found["checkpoint"] = rollouts["checkpoint"].where(~several, "each its own")
    rooms = found.assign(row=rollouts["task"]).groupby(RUN)["row"].transform("nunique")
    asked = found["task"].map(Counter(names.values()))
    return found[(rooms == asked) | (found["training_set"] == SKILL)]
