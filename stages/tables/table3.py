"""Table 3: success of every trained policy on every test asset (paper B.4)."""

from typing import Any

import pandas as pd

from stages.config.tables import TablesConfig
from stages.tables.cells import CELL, GAIN, RATE, gains, rates
from stages.tables.order import SKILL, SPLITS, set_key, task_key
from stages.tables.statistics import wilson

COLUMNS = [
    "task", "cloud", "test_asset", "feature_distance", "training_set", "run", "seed", "episodes", "successes",
    "official_successes", "success_rate", "wilson_low", "wilson_high",
]  # fmt: skip
ALL_COLUMNS = [*COLUMNS, "checkpoint", "asset", "status"]
DIFFERENCE_COLUMNS = ["task", "test_asset", "training_set", *GAIN]
CELL_COLUMNS = [*CELL, *RATE]
BASELINE, RANDOMISED, UNSEEN, TRAINED = "twin", "twin_randomised", "unseen", "trained"


def _order(row: Any) -> tuple[Any, ...]:
    order = task_key(row["task"]), set_key(row["test_asset"]), set_key(row["training_set"])
    seed = row.get("seed")
    return (*order, str(row.get("run", "")), -1 if seed is None else seed, str(row.get("checkpoint", "")))


def of_roles(rollouts: pd.DataFrame) -> pd.DataFrame:
    """The rollouts of policies on the roles of Table 3."""
    return rollouts[~rollouts["test_asset"].isin(SPLITS) & (rollouts["training_set"] != SKILL)]


def build(rollouts: pd.DataFrame, published: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """One row per (task, test asset, training set, run, seed) with `ALL_COLUMNS`.

    Args:
        rollouts: rows of `Rollout`.
        published: cells of Table 3 of the paper; a cell without rollouts becomes one row `not run`.
    """
    rows: list[dict[str, Any]] = []
    keys = [*CELL, "run", "seed", "checkpoint"]
    for key, group in of_roles(rollouts).groupby(keys):
        successes, episodes = int(group["success"].sum()), len(group)
        low, high = wilson(successes, episodes, options.confidence)
        rows.append(
            dict(zip(keys, key, strict=True))
            | {"feature_distance": float(group["feature_distance"].mean()), "asset": _assets(group["asset"])}
            | {"cloud": group["cloud"].iloc[0], "official_successes": int(group["official_success"].sum())}
            | {"episodes": episodes, "successes": successes, "success_rate": successes / episodes}
            | {"wilson_low": low, "wilson_high": high, "status": "run"}
        )
    ran = {tuple(row[name] for name in CELL) for row in rows}
    for cell in published[CELL].itertuples(index=False, name=None):
        if cell not in ran:
            rows.append(dict(zip(CELL, cell, strict=True)) | {"status": "not run"})
    table = pd.DataFrame(sorted(rows, key=_order), columns=ALL_COLUMNS)
    return table.astype(dict.fromkeys(["seed", "episodes", "successes", "official_successes"], "Int64"))


def _assets(names: pd.Series) -> str:
    """The asset of some episodes; of the role `trained` there may be several."""
    return str(names.iloc[0]) if names.nunique() == 1 else f"{names.nunique()} assets"


def cells(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """Cells of Table 3 over their runs, one asset each (`trained`: those that the policy was trained on)."""
    return rates(of_roles(rollouts), CELL, options)


def differences(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """Success of each training set minus that of the twin's, per task and test asset, with `DIFFERENCE_COLUMNS`.

    The test asset `unseen` pools all roles but the twin: what the comparison is about (paper B.4). The role `trained`
    stands for other assets in every set: there is nothing to pair.
    """
    compared = of_roles(rollouts)
    compared = compared[compared["test_asset"] != TRAINED]
    unseen = compared[compared["test_asset"] != BASELINE]
    roles = unseen.groupby("task")["test_asset"].transform("nunique")
    compared = pd.concat([compared, unseen[roles > 1].assign(test_asset=UNSEEN)])
    return gains(compared, ["task", "test_asset"], "training_set", BASELINE, options)
