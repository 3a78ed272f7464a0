"""How success over sets of unseen assets looks: a row per kind of policy, a column per training set."""

from collections.abc import Callable
from typing import Any

import pandas as pd

from stages.config.tables import TablesConfig
from stages.tables.formatting import TOLD, level, plural_runs
from stages.tables.markup import Cell, Row, Table, percent, points, span
from stages.tables.order import SKILL, kind, set_key, title
from stages.tables.rows import records
from stages.tables.table3 import BASELINE

Line = dict[str, dict[str, Any]]  # training set -> row of the table


def lines(table: pd.DataFrame, by: list[str]) -> list[tuple[tuple[Any, ...], Line]]:
    """Rows that agree in `by` with the training sets side by side, in the order in which they stand."""
    groups = table.groupby(by, sort=False)
    return [(key, {row["training_set"]: row for row in records(group)}) for key, group in groups]


def training_sets(table: pd.DataFrame) -> list[str]:
    """Columns: the training sets of policies."""
    return sorted({*table["training_set"]} - {SKILL}, key=set_key)


def _counted(row: dict[str, Any]) -> str:
    """'[70–90] 24 assets, 2 runs'."""
    assets = f"{row['assets']} asset{'s' if row['assets'] > 1 else ''}"
    return f"[{span(row['low'], row['high'])}] {assets}, {plural_runs(row['runs'])}"


def _rate(row: dict[str, Any]) -> Cell:
    return Cell(percent(row["mean"], row["std"]), _counted(row))


def _gain(name: str) -> Callable[[dict[str, Any]], Cell]:
    """A cell of a difference, empty where there is none; `name`: twin, network."""

    def cell(row: dict[str, Any]) -> Cell:
        if pd.isna(row[f"{name}_difference"]):
            return Cell("")
        return Cell(points(row[f"{name}_difference"]), f"[{span(row[f'{name}_low'], row[f'{name}_high'])}]")

    return cell


def _row(head: list[Cell], line: Line, sets: list[str], cell: Callable[[dict[str, Any]], Cell]) -> Row:
    return Row([*head, *(cell(line[name]) if name in line else Cell("") for name in sets)])


def _group(table: pd.DataFrame, sets: list[str]) -> list[Row]:
    """The rows of one group and set of assets: rates, minus the twin, minus the paper's network, the skill."""
    first = records(table)[0]
    about = f"{first['assets']} assets of {first['families']} families, {first['places']} initial states"
    group = Cell(f"{title(first['assets_of'])}, {title(first['test_asset'])}", about)
    policies = [
        (kind(task, first["assets_of"]), line)
        for (task,), line in lines(table[table["training_set"] != SKILL], ["task"])
    ]
    rows = [_row([group, Cell(name)], line, sets, _rate) for name, line in policies]
    for what, which in (("minus the twin's", "twin"), ("minus the paper's network", "network")):
        made = [_row([group, Cell(f"{name}, {what}")], line, sets, _gain(which)) for name, line in policies]
        rows += [row for row in made if any(cell.value for cell in row.cells[2:])]
    for row in records(table[table["training_set"] == SKILL]):
        counts = f"[{span(row['low'], row['high'])}] {row['successes']}/{row['episodes']}; a reference, not a policy"
        rows.append(Row([group, Cell(f"{title(SKILL)}: {percent(row['mean'])}", counts), *[Cell("")] * len(sets)]))
    return rows


def assets_table(table: pd.DataFrame, options: TablesConfig) -> Table:
    """Success over unseen assets; `table` as `assets.build` gives."""
    sets = training_sets(table) or [BASELINE]
    groups = [group for _, group in table.groupby(["assets_of", "test_asset"], sort=False)]
    return Table(
        name="assets",
        caption="Success over unseen assets, by kind of policy (rows) and training set (columns).",
        columns=["Assets", "Policies", *(title(name) for name in sets)],
        rows=[row for group in groups for row in _group(group, sets)],
        headers=2,
        notes=[
            f"Mean over assets ± sample standard deviation over runs, [{level(options)} interval]. No policy was "
            "trained on an asset of these families. Intervals: bootstrap over families of assets, their initial states "
            f"and runs, crossed ({options.bootstrap_samples} resamples, seed {options.seed}), never narrower than a "
            "score interval with assets as units (Wilson's of rates; Newcombe's, 1998, method 10, of paired "
            "differences). With one run they speak of these policies only, not of training again.",
            "Minus the twin's: what training on more than the twin adds to the same kind of policy. Minus the paper's "
            "network: what the kind of policy adds on the same demonstrations. An interval that holds zero says that "
            "this run does not tell the two apart. The scripted skill, which made the demonstrations and knows the "
            "true handle, starts from the same states.",
            TOLD,
        ],
    )


def by_handle_table(table: pd.DataFrame, options: TablesConfig) -> Table:
    """The same by kind and length of the handle; `table` as `assets.by_handle` gives."""
    sets = [*training_sets(table), *([SKILL] if (table["training_set"] == SKILL).any() else [])]
    rows = []
    for (task, split, _, handle), line in lines(table, ["task", "test_asset", "by", "handle"]):
        first = next(iter(line.values()))
        head = [Cell(title(task), title(split)), Cell(handle, f"n = {first['assets']}")]
        rows.append(_row(head, line, sets, _rate))
    return Table(
        name="assets_by_handle",
        caption="Success over unseen assets, by kind and length of the handle.",
        columns=["Task", "Handle", *(title(name) for name in sets)],
        rows=rows,
        headers=2,
        notes=[f"n: assets. Intervals ({level(options)}) as in the table over all; of a single asset about it alone."],
    )
