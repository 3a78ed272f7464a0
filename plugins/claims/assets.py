"""Success over sets of unseen assets: tables `assets` and `assets_by_handle`.

The policies of a target are a group: they share demonstrations, assets and states.
"""

from collections.abc import Mapping
from typing import get_args

import numpy as np
import pandas as pd

from roomkin.stages.config.evaluation import MethodTables, TablesConfig
from roomkin.stages.contracts.library import HandleKind
from roomkin.stages.tables.rows import CELL, RATE, SKILL, SPLITS, in_order, rates, tabulate_gains
from roomkin.stages.tables.table3 import BASELINE, RANDOMISED

FIRST = ""  # stands for the first policy of a target
ENDS = ["difference", "low", "high"]
BASELINES = {"twin": BASELINE, "randomised": RANDOMISED}  # training sets that the same policy's others are held against
FROM = {name: {old: f"{name}_{old}" for old in ENDS} for name in (*BASELINES, "network")}
COLUMNS = [*CELL, *RATE, *(column for columns in FROM.values() for column in columns.values())]
LENGTHS = [0, 0.05, 0.1, 0.2, np.inf]  # of handles, metres
BINS = ["< 5 cm", "5-10 cm", "10-20 cm", "> 20 cm"]
KINDS = sorted(get_args(HandleKind))
BY_HANDLE = [*CELL, "by", "handle", *RATE]


def of_splits(rollouts: pd.DataFrame) -> pd.DataFrame:
    """The rollouts on sets of unseen assets; the skill's as well."""
    return rollouts[rollouts["test_asset"].isin(SPLITS)]


def find_judged_set(rollouts: pd.DataFrame) -> str:
    """What unseen assets are: the set `test`, else `validation`, else (`roles`) the roles that are held out."""
    return next((split for split in SPLITS if (rollouts["test_asset"] == split).any()), "roles")


def first_policies(policies: pd.DataFrame, options: MethodTables) -> dict[str, str]:
    """Target or pool -> its first policy, which others are compared with: by the config, else by the order of rows."""
    pools = {name: pool for pool, names in options.pools.items() for name in names}
    known = reversed(options.policies.items())
    first = {pools.get(name, name): policy for policy, about in known for name in about.targets}
    return dict(policies.drop_duplicates("target")[["target", "policy"]].itertuples(index=False)) | first


def build(rollouts: pd.DataFrame, options: TablesConfig, first: Mapping[str, str]) -> pd.DataFrame:
    """A row per target, policy, set of assets and training set, with `COLUMNS`.

    `twin_difference`: minus the same policy trained on the twin; `randomised_difference`: minus that trained on the
    twin, randomised; `network_difference`: minus the first policy of the target (`first`), trained on the same set.
    """
    found = of_splits(rollouts)
    policies = found[found["training_set"] != SKILL]
    is_first = policies["policy"] == policies["target"].map(first)
    others, table = policies.assign(policy=policies["policy"].mask(is_first, FIRST)), rates(found, CELL, options)
    within = ["target", "policy", "test_asset"]
    gains = {name: tabulate_gains(policies, within, "training_set", old, options) for name, old in BASELINES.items()}
    gains["network"] = tabulate_gains(others, ["target", "test_asset", "training_set"], "policy", FIRST, options)
    for name, gained in gains.items():
        table = table.merge(gained[[*CELL, *ENDS]].rename(columns=FROM[name]), "left", CELL)
    return table[COLUMNS]


def by_handle(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """A row per target, policy, set of assets, training set, bin of handles (`by`: kind, length), with `BY_HANDLE`."""
    found = of_splits(rollouts)
    lengths = pd.cut(found["handle_length"], LENGTHS, labels=BINS, right=False).astype(str)
    binned = pd.concat([found.assign(by="kind"), found.assign(by="length", handle=lengths)])
    table = rates(binned, [*CELL, "by", "handle"], options)[BY_HANDLE]
    return in_order(table.sort_values("handle", key=lambda names: names.map([*KINDS, *BINS].index), kind="stable"))
