"""Table 3: success of every trained policy on every test asset (paper B.4)."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from stages.config.tables import TablesConfig
from stages.tables.difference import difference_interval
from stages.tables.order import set_key, task_key
from stages.tables.statistics import mean, std, wilson

COLUMNS = [
    "task", "cloud", "test_asset", "dino_distance", "training_set", "run", "seed", "episodes", "successes",
    "official_successes", "success_rate", "wilson_low", "wilson_high",
]  # fmt: skip
ALL_COLUMNS = [*COLUMNS, "checkpoint", "asset", "status"]
DIFFERENCE_COLUMNS = [
    "task", "test_asset", "training_set", "baseline", "states", "runs", "baseline_runs", "difference", "low", "high",
]  # fmt: skip
CELL = ["task", "test_asset", "training_set"]
POOLED = [
    *CELL, "cloud", "dino_distance", "runs", "episodes", "successes", "official_successes", "mean", "std",
    "low", "high",
]  # fmt: skip
BASELINE, UNSEEN, TRAINED = "twin", "unseen", "trained"


def _order(row: Any) -> tuple[Any, ...]:
    order = task_key(row["task"]), set_key(row["test_asset"]), set_key(row["training_set"])
    seed = row.get("seed")
    return (*order, str(row.get("run", "")), -1 if seed is None else seed, str(row.get("checkpoint", "")))


def build(rollouts: pd.DataFrame, published: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """One row per (task, test asset, training set, run, seed) with `ALL_COLUMNS`.

    Args:
        rollouts: rows of `Rollout`.
        published: cells of Table 3 of the paper; a cell without rollouts becomes one row `not run`.
    """
    rows: list[dict[str, Any]] = []
    keys = [*CELL, "run", "seed", "checkpoint"]
    for key, group in rollouts.groupby(keys):
        successes, episodes = int(group["success"].sum()), len(group)
        low, high = wilson(successes, episodes, options.confidence)
        rows.append(
            dict(zip(keys, key, strict=True))
            | {"dino_distance": float(group["dino_distance"].mean()), "asset": _assets(group["asset"])}
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


def pool(table: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Cells of Table 3 over their runs: mean and sample std of the runs' rates, and the pooled Wilson interval.

    Columns: `POOLED`. The
    interval treats all episodes of a cell as alike, which holds within a run; `std` shows how runs differ.
    """
    rows = []
    for cell, group in table[table["status"] == "run"].groupby(CELL, sort=False):
        successes, episodes = int(group["successes"].sum()), int(group["episodes"].sum())
        low, high = wilson(successes, episodes, confidence)
        rates = group["success_rate"].astype(float)
        rows.append(
            dict(zip(CELL, cell, strict=True))
            | {"cloud": group["cloud"].iloc[0], "dino_distance": float(group["dino_distance"].iloc[0])}
            | {"runs": len(group), "episodes": episodes, "successes": successes}
            | {"official_successes": int(group["official_successes"].sum())}
            | {"mean": mean(rates), "std": std(rates), "low": low, "high": high}
        )
    return pd.DataFrame(rows, columns=POOLED)


def _successes(rollouts: pd.DataFrame) -> pd.DataFrame:
    """Successes as a (policy, start) table; NaN where a policy never started from there."""
    return rollouts.pivot_table(
        index=["run", "seed", "checkpoint"], columns=["test_asset", "initial_state"], values="success", aggfunc="mean"
    ).astype(float)


def differences(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """Success of each training set minus that of the twin's, per task and test asset, with `DIFFERENCE_COLUMNS`.

    Only initial states from which every policy of both sets was started are compared, so that the pairs are whole.
    The test asset `unseen` pools all test assets but the twin: what the comparison is about (paper B.4). The role
    `trained` stands for other assets in every set: there is nothing to pair.
    """
    rows: list[dict[str, Any]] = []
    rollouts = rollouts[rollouts["test_asset"] != TRAINED]
    for task, episodes in rollouts.groupby("task"):
        groups = {str(asset): group for asset, group in episodes.groupby("test_asset")}
        if len(set(groups) - {BASELINE}) > 1:
            groups[UNSEEN] = episodes[episodes["test_asset"] != BASELINE]
        for test_asset, group in groups.items():
            rows += [{"task": task, "test_asset": test_asset} | row for row in _compared(group, options)]
    return pd.DataFrame(sorted(rows, key=_order), columns=DIFFERENCE_COLUMNS)


def _compared(rollouts: pd.DataFrame, options: TablesConfig) -> Iterator[dict[str, Any]]:
    """Every training set against the twin's, from the starts that all their policies share."""
    sets = {str(name): _successes(part) for name, part in rollouts.groupby("training_set")}
    baseline = sets.pop(BASELINE, None)
    for name, ours in sets.items() if baseline is not None else ():
        both = pd.concat([ours, baseline], keys=["ours", "baseline"]).dropna(axis="columns")
        if both.empty or both.shape[1] == 0:
            continue
        a, b = (np.asarray(both.loc[side], dtype=float) for side in ("ours", "baseline"))
        low, high = difference_interval(a, b, options.confidence, options.bootstrap_samples, options.seed)
        yield {
            "training_set": name, "baseline": BASELINE, "states": both.shape[1], "runs": len(a),
            "baseline_runs": len(b), "difference": float(a.mean() - b.mean()), "low": low, "high": high,
        }  # fmt: skip
