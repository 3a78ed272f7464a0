"""The results of the policies: charts of success with intervals, and the verdict on the paper's main claim."""

from dataclasses import dataclass
from textwrap import fill
from typing import Any

import pandas as pd
from markupsafe import Markup

from stages.tables.methods import Kinds, kind
from stages.tables.order import SKILL, set_key, task_key, title
from stages.tables.page.charts import success_chart
from stages.tables.policy_tables import claim_sentence, evidence, too_few_runs
from stages.tables.rows import records


@dataclass(frozen=True)
class Result:
    """Of a group of rows of the experiment: a chart, and sentences that judge a claim."""

    group: str
    title: str
    about: str
    chart: Markup
    verdicts: list[str]


def _said(row: dict[str, Any]) -> str:
    few = too_few_runs(row)
    return f"cannot be said from {few}" if few else str(row["verdict"])


def verdicts(claims: pd.DataFrame | None, tasks: pd.Series) -> list[str]:
    """Whether cousins help on unseen assets, a sentence per row of the experiment."""
    if claims is None:
        return []
    rows = records(claims[(claims["claim"] == "unseen") & claims["task"].isin(tasks)])
    return [f"{title(row['task'])}. {claim_sentence(row)}: {_said(row)} ({evidence(row)})." for row in rows]


def over_assets(table: pd.DataFrame | None, claims: pd.DataFrame | None, kinds: Kinds) -> list[Result]:
    """One for every group of rows with unseen assets, over its first set; `table` as `assets.build` gives."""
    found = []
    for group in table["assets_of"].unique() if table is not None else ():
        mine = table[table["assets_of"] == group]  # type: ignore[index]
        policies = mine[mine["training_set"] != SKILL]
        if policies.empty:
            continue
        split = policies["test_asset"].iloc[0]
        policies = policies[policies["test_asset"] == split]
        skill = mine[(mine["training_set"] == SKILL) & (mine["test_asset"] == split)]["mean"]
        rows = {task: fill(kind(task, kinds), 24) for task in policies["task"].unique()}
        about = f"success over {policies['assets'].iloc[0]} {title(split)} of families that no policy was trained on"
        label = f"{title(group)}: {about}, by kind of policy and training set; the numbers are in the table of assets"
        chart = success_chart(policies, label, rows, "task", float(skill.iloc[0]) if len(skill) else None)
        found.append(Result(group, title(group), about, chart, verdicts(claims, policies["task"])))
    return found


def over_roles(cells: pd.DataFrame | None, claims: pd.DataFrame | None) -> list[Result]:
    """One for every row of the experiment with rollouts on the roles of Table 3, in the paper's order."""
    found = []
    for task in sorted(cells["task"].unique(), key=task_key) if cells is not None else []:
        mine = cells[cells["task"] == task]  # type: ignore[index]
        label = f"{title(task)}: success by test asset and training set, with intervals; the numbers are in Table 3"
        roles = {name: title(name) for name in sorted(mine["test_asset"].unique(), key=set_key)}
        about, chart = "success of the policies by test asset", success_chart(mine, label, roles, "test_asset")
        group = str(mine["assets_of"].iloc[0])
        found.append(Result(group, title(task), about, chart, verdicts(claims, mine["task"])))
    return found
