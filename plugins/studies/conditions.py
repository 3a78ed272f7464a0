"""`conditions`: success under further conditions (another simulator, a depth camera's noise), paired with ours."""

from itertools import pairwise
from pathlib import Path

import pandas as pd

from roomkin.plugins.claims.assets import BASELINES
from roomkin.stages.config.evaluation import USUAL, MethodTables, TablesConfig
from roomkin.stages.contracts.errors import InputError, count
from roomkin.stages.contracts.files import read_options
from roomkin.stages.tables.policy_tables import read_pooled
from roomkin.stages.tables.rows import CELL, SKILL, in_order, rates, records, row_title, tabulate_gains, title
from roomkin.stages.tables.text import TextTable, cell, percent, points, span, write

ENDS = {"difference": "difference", "low": "difference_low", "high": "difference_high"}
COLUMNS = [*CELL, "task", "condition", "assets", "runs", "episodes", "successes", "mean", "low", "high", *ENDS.values()]


def run(
    *, out: Path, rollouts: tuple[Path, ...], elsewhere: tuple[Path, ...], names: tuple[str, ...], options: str = ""
) -> None:
    """Write conditions.csv, .html and .tex: every policy and skill under each condition, and minus the usual one.

    Args:
        out: folder to write into.
        rollouts: rollouts.csv files under the usual condition.
        elsewhere: rollouts.csv files under others, each below a folder `conditions` and one called as its condition.
        names: of the conditions.
        options: JSON of the config section `tables`, and of what is pooled.
    """
    settings = read_options(MethodTables, options)
    by_name: dict[str, list[Path]] = {name: [] for name in names}
    for path in elsewhere:
        by_name[_find_condition(path, names)].append(path)
    files = {USUAL: list(rollouts)} | {name: paths for name, paths in by_name.items() if paths}
    frames = [read_pooled(paths, settings).assign(condition=name) for name, paths in files.items()]
    table = build(pd.concat(frames, ignore_index=True), settings)
    write(out, "conditions", table, [conditions_table(table)])


def _find_condition(path: Path, names: tuple[str, ...]) -> str:
    found = [part for before, part in pairwise(path.parts) if before == "conditions" and part in names]
    if not found:
        raise InputError(path, f"lies below no folder of a condition ({', '.join(names)}).", code="E-CONDITIONS-NAMES")
    return found[0]


def build(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """A row per target, policy, test asset, training set and condition, with `COLUMNS`.

    Args:
        rollouts: rows of `Rollout` with a column `condition`; `usual` is what the others are compared with, at the same
            assets and initial states by the same policies.
    """
    by = [*CELL, "condition"]
    table = rates(rollouts, by, options)
    gains = tabulate_gains(rollouts, CELL, "condition", USUAL, options, same=True)
    merged = table.merge(gains[[*by, *ENDS]].rename(columns=ENDS), "left", by)[COLUMNS]
    return in_order(merged.sort_values("condition", key=lambda names: names.where(names != USUAL, "")))


def against_baselines(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """Success of every training set minus that of each baseline, under each condition: what is left of the gain."""
    within = ["target", "task", "policy", "test_asset", "condition"]
    policies = rollouts[rollouts["training_set"] != SKILL]
    parts = [
        tabulate_gains(policies, within, "training_set", baseline, options).assign(baseline=baseline)
        for baseline in BASELINES.values()
    ]
    return pd.concat(parts, ignore_index=True)


def baselines_table(table: pd.DataFrame) -> TextTable:
    """The rows of `against_baselines` as text."""
    rows = []
    for row in records(table):
        runs = f"{row['assets']} assets, {row['runs']} against {count(row['baseline_runs'], 'run')}"
        gain = cell(points(row["difference"]), f"[{span(row['low'], row['high'])}] {runs}")
        names = (row[name] for name in ("test_asset", "training_set", "baseline", "condition"))
        rows.append([row_title(row), *map(title, names), gain])
    return TextTable(
        "gains_under_conditions",
        "What a training set gains over a baseline, under each condition",
        ["policy", "tested on", "trained on", "minus", "condition", "difference"],
        rows,
        headers=5,
        notes=["Both sides on the same assets from the same initial states."],
    )


def conditions_table(table: pd.DataFrame) -> TextTable:
    """The rows as text."""
    rows = []
    for row in records(table):
        remark = f"[{span(row['low'], row['high'])}] {count(row['assets'], 'asset')}, {count(row['runs'], 'run')}"
        difference = ""
        if not pd.isna(row["difference"]):
            between = span(row["difference_low"], row["difference_high"])
            difference = cell(points(row["difference"]), f"[{between}]")
        names = (row[name] for name in ("test_asset", "training_set", "condition"))
        rows.append([row_title(row), *map(title, names), cell(percent(row["mean"]), remark), difference])
    return TextTable(
        "conditions",
        "Success under other conditions: mean over assets, 95 % interval over assets, states and runs",
        ["policy", "tested on", "trained on", "condition", "success", "minus usual"],
        rows,
        headers=4,
        notes=["Differences are of the same policies on the same assets from the same initial states."],
    )
