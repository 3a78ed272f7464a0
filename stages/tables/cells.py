"""Success rates and differences of rates with their intervals, of any groups of rollouts."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from roomkin.stages.config.tables import TablesConfig
from roomkin.stages.tables.intervals import difference_interval, pair_sides, rate_interval, rate_of, side_of
from roomkin.stages.tables.order import SKILL, set_key

ROW = ["target", "task", "policy"]
CELL = ["target", "policy", "test_asset", "training_set"]
RATE = [
    "task", "cloud", "feature_distance", "assets", "families", "places", "runs", "episodes", "successes",
    "official_successes", "steps", "mean", "std", "low", "high",
]  # fmt: skip
GAIN = ["assets", "places", "runs", "baseline_runs", "difference", "low", "high"]


def in_order(table: pd.DataFrame, by: Sequence[str] = CELL) -> pd.DataFrame:
    """Targets and policies in the order in which they come, in the paper's order of test assets and training sets."""

    def places(column: pd.Series) -> pd.Series:
        if column.name in ROW:
            return pd.Series(pd.factorize(column)[0], column.index).mask(column == SKILL, len(column))
        return column.map(set_key) if column.name in CELL else column

    return table.sort_values([name for name in by if name in table], key=places, ignore_index=True)


def rates(rollouts: pd.DataFrame, by: Sequence[str], options: TablesConfig) -> pd.DataFrame:
    """A row per group of rollouts that agree in `by`, with `RATE`.

    `mean`: over assets, their states and runs, assets alike; `std`: sample deviation over runs; `places`: initial
    states over all assets; `steps`: the mean of the episodes that succeed, NaN: none does.
    """
    rows: list[dict[str, Any]] = []
    for key, group in rollouts.groupby(list(by), sort=False):
        side = side_of(group)
        low, high = rate_interval(side, options)
        rows.append(
            dict(zip(by, key, strict=True))
            | {"task": group["task"].iloc[0], "cloud": group["cloud"].iloc[0]}
            | {"feature_distance": float(group["feature_distance"].mean()), "places": side.shape[1], "runs": len(side)}
            | {"assets": group["asset"].nunique(), "families": group["family"].nunique(), "episodes": len(group)}
            | {"successes": int(group["success"].sum()), "official_successes": int(group["official_success"].sum())}
            | {"steps": float(group.loc[group["success"], "steps"].mean())}
            | {"mean": rate_of(side), "std": side.mean(axis=1).std(), "low": low, "high": high}
        )
    return in_order(pd.DataFrame(rows, columns=list(dict.fromkeys([*by, *RATE]))))


def tabulate_gains(
    rollouts: pd.DataFrame, within: Sequence[str], side: str, baseline: str, options: TablesConfig, same: bool = False
) -> pd.DataFrame:
    """Success of every value of the column `side` minus that of `baseline`, a row each with `within`, `side`, `GAIN`.

    Only places where all policies of both were tested are compared, so that the pairs are whole.

    Args:
        same: both sides are the same policies: those that are on one alone are left out.
    """
    rows: list[dict[str, Any]] = []
    for key, group in rollouts.groupby(list(within), sort=False):
        sides = {str(name): side_of(part) for name, part in group.groupby(side, sort=False)}
        for name in sides if baseline in sides else ():
            ours, theirs = sides[name], sides[baseline]
            if same:
                policies = ours.index.intersection(theirs.index)
                ours, theirs = ours.loc[policies], theirs.loc[policies]
            ours, theirs = pair_sides(ours, theirs)
            if name == baseline or ours.empty:
                continue
            low, high = difference_interval(ours, theirs, options, same)
            rows.append(
                dict(zip(within, key, strict=True))
                | {side: name, "assets": ours.columns.get_level_values("asset").nunique(), "places": ours.shape[1]}
                | {"runs": len(ours), "baseline_runs": len(theirs)}
                | {"difference": rate_of(ours) - rate_of(theirs), "low": low, "high": high}
            )
    return in_order(pd.DataFrame(rows, columns=[*within, side, *GAIN]))
