"""The one result of the policies: success by test asset, and what cousins gain over the twin, as far as is known."""

from dataclasses import dataclass
from typing import Any

import pandas as pd
from markupsafe import Markup

from stages.tables.claims import most_cousins
from stages.tables.markup import points, span
from stages.tables.order import set_key, task_key, title
from stages.tables.page.charts import success_chart
from stages.tables.rows import records
from stages.tables.table3 import BASELINE, TRAINED, UNSEEN


@dataclass(frozen=True)
class Result:
    """Of one task: a chart, and a sentence on the training set of most cousins against the twin."""

    title: str
    chart: Markup
    verdicts: list[str]


def verdict(row: dict[str, Any], counts: dict[str, str]) -> str:
    """What a difference says; that it says nothing if its interval holds zero."""
    name = title(row["training_set"])
    measured = (
        f"on unseen assets, {name}: {counts[row['training_set']]}, twin: {counts[BASELINE]}; "
        f"{points(row['difference'])} [{span(row['low'], row['high'])}]"
    )
    if row["low"] > 0 or row["high"] < 0:
        more = "more" if row["low"] > 0 else "less"
        return f"Policies trained on {name} succeed {more} often than those trained on the twin ({measured})."
    return f"This run does not tell training on {name} apart from training on the twin ({measured}, which holds zero)."


def _counts(cells: pd.DataFrame) -> dict[str, str]:
    """'9 of 48' for every training set, over the test assets that are not the twin."""
    unseen = cells[~cells["test_asset"].isin([BASELINE, TRAINED])]
    sums = unseen.groupby("training_set")[["successes", "episodes"]].sum()
    return {str(name): f"{int(row.successes)} of {int(row.episodes)}" for name, row in sums.iterrows()}


def results(pooled: pd.DataFrame | None, gains: pd.DataFrame | None) -> list[Result]:
    """One for every task whose policies were rolled out, in the paper's order."""
    if pooled is None or pooled.empty:
        return []
    made = []
    for task in sorted(pooled["task"].unique(), key=task_key):
        cells = pooled[pooled["task"] == task]
        counts = _counts(cells)
        rows = [] if gains is None else records(gains[(gains["task"] == task) & (gains["test_asset"] == UNSEEN)])
        rows = [row for row in rows if row["training_set"] in counts and BASELINE in counts]
        rows = sorted(rows, key=lambda row: set_key(row["training_set"]))
        most = most_cousins([row["training_set"] for row in rows])  # the others stand in the tables
        verdicts = [verdict(row, counts) for row in rows if row["training_set"] == most or most is None]
        label = f"{title(task)}: success by test asset and training set, with intervals; the numbers are in Table 3"
        made.append(Result(title(task), success_chart(cells, label), verdicts))
    return made
