"""How measured success compares with what was expected before any rollout, cell by cell."""

from typing import Any

import numpy as np
import pandas as pd

from plugins.claims.claims import MIN_SPREAD_RUNS
from stages.tables.markup import Table
from stages.tables.order import task_title, title
from stages.tables.rows import records
from stages.tables.statistics import NAN
from stages.tables.text import NOT_RUN, number, percent, points

FORECAST = ["task", "object", "training_set", "seed", "forecast"]
AGREEMENT = ["condition", "task", "cells", "measured", "forecast", "error", "correlation", "slope"]
BINS = (0.0, 0.25, 0.5, 0.75, 1.0)


def measure_agreement(cells: pd.DataFrame) -> pd.DataFrame:
    """A row with `AGREEMENT` per condition and task, over its policies that have run and have a forecast.

    error: mean absolute difference; slope: of measured against forecast success, 1 where the forecast is calibrated.
    Below follow rows with `forecast` binned, in `bin`: of those cells alone.

    Args:
        cells: rows with `condition`, `task`, `success`, `forecast`.
    """
    rows: list[dict[str, Any]] = []
    for (condition, task), part in cells.groupby(["condition", "task"], sort=False):
        known = part.dropna(subset=["success", "forecast"]).astype({"success": float, "forecast": float})
        about = {"condition": condition, "task": task}
        rows.append(about | {"bin": "all"} | _fit(known))
        binned = known.groupby(pd.cut(known["forecast"], BINS, include_lowest=True), observed=True)
        rows += [about | {"bin": f"{left.left:.2f} to {left.right:.2f}"} | _fit(each) for left, each in binned]
    return pd.DataFrame(rows, columns=[*AGREEMENT[:2], "bin", *AGREEMENT[2:]])


def _fit(cells: pd.DataFrame) -> dict[str, Any]:
    measured, forecast = cells["success"].to_numpy(), cells["forecast"].to_numpy()
    correlation = slope = NAN
    if len(cells) >= MIN_SPREAD_RUNS and measured.std() > 0 and forecast.std() > 0:
        correlation = float(np.corrcoef(forecast, measured)[0, 1])
        slope = float(correlation * measured.std() / forecast.std())
    error = float(np.abs(measured - forecast).mean()) if len(cells) else NAN
    means = {"measured": cells["success"].mean(), "forecast": cells["forecast"].mean()}
    return {"cells": len(cells), **means, "error": error, "correlation": correlation, "slope": slope}


def agreement_table(table: pd.DataFrame) -> Table:
    """The rows as text."""
    rows = []
    for row in records(table):
        cells = [str(row["cells"])] if row["cells"] else [NOT_RUN]
        if row["cells"]:
            cells += [percent(row["measured"]), percent(row["forecast"]), points(row["error"]).lstrip("+")]
            cells += [number(row["correlation"], 2), number(row["slope"], 2)]
        rows.append([task_title(row["task"]), title(row["condition"]), row["bin"], *cells, *[""] * (6 - len(cells))])
    return Table(
        "agreement",
        "Measured success and forecast, policy by policy.",
        [
            "Task",
            "Condition",
            "Forecast",
            "Policies",
            "Measured",
            "Forecast, mean",
            "Mean error",
            "Correlation",
            "Slope",
        ],
        rows,
        headers=3,
    )
