"""The results of the policies: success with intervals, and what may be said of differences."""

from dataclasses import dataclass
from typing import Any

import pandas as pd
from markupsafe import Markup

from stages.tables.claims import most_cousins
from stages.tables.markup import percent, points, span
from stages.tables.order import SKILL, ending, kind, set_key, task_key, title
from stages.tables.page.charts import success_chart
from stages.tables.rows import records
from stages.tables.table3 import BASELINE, UNSEEN


@dataclass(frozen=True)
class Result:
    """Of one row or group of rows of the experiment: a chart and what may be said."""

    group: str
    title: str
    about: str
    chart: Markup
    verdicts: list[str]


def verdict(ours: str, theirs: str, row: dict[str, Any], measured: str) -> str:
    """What a difference says; that it says nothing if its interval holds zero."""
    measured = f"{measured}; {points(row['difference'])} [{span(row['low'], row['high'])}]"
    if row["low"] > 0 or row["high"] < 0:
        more = "more" if row["low"] > 0 else "less"
        return f"{ours[0].upper()}{ours[1:]} succeed {more} often than {theirs} ({measured})."
    return f"This run does not tell {ours} apart from {theirs} ({measured}, which holds zero)."


def _who(task: str, group: str) -> str:
    """The policies of a row of the experiment, as the subject of a sentence."""
    known = {"": "the paper's policies", "_handle": "policies that see the handle"}
    return known[ending(task)] if ending(task) or task == group else f"policies ({kind(task, group)})"


def _compared(row: dict[str, Any], theirs: dict[str, Any], versus: str, names: tuple[str, str]) -> str:
    """The verdict on a difference over unseen assets; `versus`: twin, network."""
    ends = {name: row[f"{versus}_{name}"] for name in ("difference", "low", "high")}
    return verdict(*names, ends, f"{percent(row['mean'])} against {percent(theirs['mean'])}, {row['assets']} assets")


def _verdicts(table: pd.DataFrame, group: str) -> list[str]:
    """A sentence per comparison: most cousins with the twin, policies that see the handle with the paper's."""
    rows = {(row["task"], row["training_set"]): row for row in records(table) if ending(row["task"]) != "_blind"}
    most, texts = most_cousins(table["training_set"]), []
    for (task, name), row in rows.items():
        trained = "the twin" if name == BASELINE else title(name)
        ours = f"{_who(task, group)} trained on {trained}"
        if name == most and pd.notna(row["twin_difference"]):
            texts.append(_compared(row, rows[task, BASELINE], "twin", (ours, "those trained on the twin")))
        if name in (BASELINE, most) and pd.notna(row["network_difference"]):
            texts.append(
                _compared(row, rows[group, name], "network", (ours, "the paper's policies trained on the same"))
            )
    return texts


def over_assets(table: pd.DataFrame | None) -> list[Result]:
    """One for every group of rows with unseen assets, over its first set; `table` as `assets.build` gives."""
    made: dict[str, Result] = {}
    if table is None:
        return []
    for (group, split), cells in [
        ((str(a), str(b)), part) for (a, b), part in table.groupby(["assets_of", "test_asset"], sort=False)
    ]:
        if group in made:
            continue
        skill = cells[cells["training_set"] == SKILL]["mean"]
        policies = cells[cells["training_set"] != SKILL]
        rows = {str(task): kind(str(task), group) for task in policies["task"].unique()}
        if not rows:
            continue
        first = records(policies)[0]
        about = f"success over {first['assets']} {title(split)} that no policy was trained on, nor on their families"
        label = f"{title(group)}: {about}, by kind of policy and training set; the numbers are in the table of assets"
        chart = success_chart(policies, label, rows, "task", float(skill.iloc[0]) if len(skill) else None)
        made[group] = Result(group, title(group), about, chart, _verdicts(policies, group))
    return list(made.values())


def over_roles(cells: pd.DataFrame | None, gains: pd.DataFrame | None) -> list[Result]:
    """One for every row of the experiment with rollouts on the roles of Table 3, in the paper's order."""
    made: list[Result] = []
    if cells is None:
        return made
    for task in sorted(cells["task"].unique(), key=task_key):
        mine = cells[cells["task"] == task]
        rows = [] if gains is None else records(gains[(gains["task"] == task) & (gains["test_asset"] == UNSEEN)])
        most = most_cousins([row["training_set"] for row in rows])  # the others stand in the tables
        verdicts = [
            verdict(
                f"policies trained on {title(row['training_set'])}",
                "those trained on the twin",
                row,
                f"on the {row['assets']} held-out roles",
            )
            for row in rows
            if row["training_set"] == most or most is None
        ]
        label = f"{title(task)}: success by test asset and training set, with intervals; the numbers are in Table 3"
        roles = {name: title(name) for name in sorted(mine["test_asset"].unique(), key=set_key)}
        chart = success_chart(mine, label, roles, "test_asset")
        group = str(mine["assets_of"].iloc[0])
        made.append(Result(group, title(task), "success of the policies by test asset", chart, verdicts))
    return made
