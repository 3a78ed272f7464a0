"""Pools of targets: what policies do on the objects of several rooms, as one row of the tables."""

from collections.abc import Iterable

import pandas as pd

from roomkin.stages.config.tables import MethodTables
from roomkin.stages.tables.order import SKILL

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
