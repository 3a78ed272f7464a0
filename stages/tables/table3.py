"""Table 3: success of every trained policy on every test asset (paper B.4)."""

from typing import Any

import pandas as pd

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.tables.intervals import wilson
from roomkin.stages.tables.rows import CELL, GAIN, SKILL, SPLITS, in_order, rates, records, tabulate_gains

COLUMNS = [
    "target", "task", "policy", "cloud", "test_asset", "feature_distance", "training_set", "run", "seed", "episodes",
    "successes", "official_successes", "steps", "success_rate", "wilson_low", "wilson_high",
]  # fmt: skip
ALL_COLUMNS = [*COLUMNS, "checkpoint", "asset", "status"]
DIFFERENCE_COLUMNS = [*CELL, *GAIN]
BASELINE, RANDOMISED, UNSEEN, TRAINED = "twin", "twin_randomised", "unseen", "trained"


def of_test_assets(rollouts: pd.DataFrame) -> pd.DataFrame:
    """The rollouts of policies on the test assets of Table 3."""
    return rollouts[~rollouts["test_asset"].isin(SPLITS) & (rollouts["training_set"] != SKILL)]


def build(rollouts: pd.DataFrame, asked: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """One row per (target, policy, test asset, training set, run, seed) with `ALL_COLUMNS`; a cell of `asked`, with its
    task, that has no rollouts becomes one row `not run`."""
    rows: list[dict[str, Any]] = []
    keys = [*CELL, "run", "seed", "checkpoint"]
    for key, group in of_test_assets(rollouts).groupby(keys, sort=False):
        successes, episodes = int(group["success"].sum()), len(group)
        low, high = wilson(successes, episodes, options.confidence)
        rows.append(
            dict(zip(keys, key, strict=True))
            | {"feature_distance": float(group["feature_distance"].mean()), "asset": _assets(group["asset"])}
            | {"task": group["task"].iloc[0], "cloud": group["cloud"].iloc[0]}
            | {"official_successes": int(group["official_success"].sum())}
            | {"steps": float(group.loc[group["success"], "steps"].mean())}
            | {"episodes": episodes, "successes": successes, "success_rate": successes / episodes}
            | {"wilson_low": low, "wilson_high": high, "status": "run"}
        )
    ran = {tuple(row[name] for name in CELL) for row in rows}
    lacking = [cell for cell in records(asked[[*CELL, "task"]]) if tuple(cell[name] for name in CELL) not in ran]
    rows += [cell | {"status": "not run"} for cell in lacking]
    table = in_order(pd.DataFrame(rows, columns=ALL_COLUMNS), keys)
    table = table.sort_values("policy", key=lambda policy: policy == "", kind="stable")  # the paper's alone at the end
    return table.astype(dict.fromkeys(["seed", "episodes", "successes", "official_successes"], "Int64"))


def _assets(names: pd.Series) -> str:
    """The asset of some episodes; of `trained` there may be several."""
    return str(names.iloc[0]) if names.nunique() == 1 else f"{names.nunique()} assets"


def cells(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """Cells of Table 3 over their runs, one asset each (`trained`: those that the policy was trained on)."""
    return rates(of_test_assets(rollouts), CELL, options)


def differences(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """Success of a training set minus that of the twin's, per target, policy and test asset: `DIFFERENCE_COLUMNS`.

    The test asset `unseen` pools all but the twin: what the comparison is about (paper B.4). `trained` stands for
    other assets in every set: there is nothing to pair.
    """
    compared = of_test_assets(rollouts)
    compared = compared[compared["test_asset"] != TRAINED]
    unseen = compared[compared["test_asset"] != BASELINE]
    tested = unseen.groupby(["target", "policy"])["test_asset"].transform("nunique")
    compared = pd.concat([compared, unseen[tested > 1].assign(test_asset=UNSEEN)])
    return tabulate_gains(compared, ["target", "policy", "test_asset"], "training_set", BASELINE, options)
