"""The tables of verb `sets` as text."""

from typing import Any

import pandas as pd

from stages.tables.markup import Table
from stages.tables.order import task_title, title
from stages.tables.rows import records
from stages.tables.text import NOT_RUN, cell, count, percent, points, span

WHERE = ["Task", "Condition"]


def sets_table(table: pd.DataFrame) -> Table:
    """A row per task, condition and training set; `table` as `sets.of_sets` gives."""
    rows = []
    for row in records(table):
        policies = f"{row['policies']} of {row['policies_asked']} policies"
        if row["status"] != "run":
            rows.append([*_name_row(row), title(row["training_set"]), NOT_RUN, policies, ""])
            continue
        size = f"{count(row['objects'], 'object')}, {policies}, {row['families']} families"
        rows.append([*_name_row(row), title(row["training_set"]), _rate(row), size, percent(row["forecast"])])
    columns = [*WHERE, "Training set", "Unseen assets opened", "Of", "Forecast"]
    return Table("sets", "Success over unseen assets, objects alike.", columns, rows, headers=3)


def comparisons_table(table: pd.DataFrame) -> Table:
    """A row per task, condition and pair of training sets; `table` as `sets.compare` gives."""
    rows = []
    for row in records(table):
        pair = f"{title(row['training_set'])} minus {title(row['baseline'])}"
        if not row["rollouts"]:
            rows.append([*_name_row(row), pair, NOT_RUN, "", "", "", f"0 of {row['objects_asked']} objects"])
            continue
        verdict = f"{row['verdict']}{', preliminary' if row['preliminary'] else ''}"
        crossed = span(row["crossed_low"], row["crossed_high"]) if row["crossed_low"] == row["crossed_low"] else ""
        learned = cell(points(row["learned_mean"]), _span(row["learned_low"], row["learned_high"]))
        forecast = "" if row["forecast"] != row["forecast"] else points(row["forecast"])
        size = f"{row['objects']} of {row['objects_asked']} objects, {row['families']} families"
        gain = cell(points(row["mean"]), _span(row["low"], row["high"]), verdict)
        rows.append([*_name_row(row), pair, gain, crossed, forecast, learned, size])
    return Table(
        "comparisons",
        "Training sets compared, on the same unseen assets, in percentage points.",
        [*WHERE, "Pair", "Difference", "Crossed bootstrap", "Forecast", "Without failed trainings", "Of"],
        rows,
        headers=3,
        notes=[
            "[95 %: clustered by objects and by families of assets, t over objects]. Crossed bootstrap: objects, "
            "families and runs are drawn; it counts the chance of single rollouts three times. Preliminary: not all "
            "policies have run."
        ],
    )


def _name_row(row: dict[str, Any]) -> list[str]:
    return [task_title(row["task"]), title(row["condition"])]


def _rate(row: dict[str, Any]) -> str:
    return cell(percent(row["mean"]), _span(max(row["low"], 0.0), min(row["high"], 1.0)))


def _span(low: float, high: float) -> str:
    return "no interval" if low != low else f"[{span(low, high)}]"
