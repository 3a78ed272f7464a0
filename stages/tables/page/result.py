"""The results of the policies: charts of success with intervals, and what cousins brought, in a sentence each."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any

import pandas as pd
from markupsafe import Markup

from stages.tables.claims import OPEN
from stages.tables.methods import Kinds, kind
from stages.tables.order import SKILL, set_key, task_key, title, title_of
from stages.tables.page.charts import success_chart
from stages.tables.page.rooms import RoomPart
from stages.tables.policy_tables import evidence, too_few_runs
from stages.tables.rows import records
from stages.tables.text import count, percent


@dataclass(frozen=True)
class Result:
    """Of a group of rows of the experiment: a chart; what cousins brought, in a line and in sentences."""

    group: str
    title: str
    about: str
    chart: Markup
    gain: str
    verdicts: list[str]


AGAIN = Markup(
    "The intervals are over assets and starts, for these policies alone. With one seed nothing can be said about "
    "training again: set <code>experiment: {seeds: [0, 1]}</code>."
)


def _ends(row: dict[str, Any]) -> str:
    return f"{percent(row['theirs'])} → {percent(row['ours'])}".replace(" ", "\N{NO-BREAK SPACE}")


def _verdict(row: dict[str, Any], name: str) -> str:
    """The difference, its interval, and whom it is about."""
    text = f"{name}: {_ends(row)}, {evidence(row)} with {title(row['training_set'])} instead of the twin"
    if too_few_runs(row):
        return f"{text}, for these policies."
    seeds = f"over {row['runs']} and {row['baseline_runs']} seeds of training"
    said = "whether cousins help cannot be said" if row["verdict"] == OPEN else f"that cousins help {row['verdict']}"
    return f"{text}, {seeds}: {said}."


def sentences(claims: pd.DataFrame | None, names: dict[str, str]) -> tuple[str, list[str]]:
    """What cousins brought on unseen assets in a line, and in a sentence for each of `names`.

    Args:
        names: row of the experiment -> what its policies are called.
    """
    if claims is None:
        return "", []
    rows = records(claims[(claims["claim"] == "unseen") & claims["task"].isin(list(names))])
    if not rows:
        return "", []
    first = rows[0]
    over = title_of(first["assets"], "unseen" if first["over"] == "roles" else first["over"])
    whose = {task: name.replace(" (", ", ").rstrip(")") for task, name in names.items()}
    alike = [row for row in rows if all(row[key] == first[key] for key in ("over", "assets", "training_set"))]
    ends = ", ".join(f"{_ends(row)}, {evidence(row)}" + f" ({whose[row['task']]})" * (len(alike) > 1) for row in alike)
    what = title(first["task"])
    line = f"success at {what[0].lower()}{what[1:]} on {over}, trained on {title(first['training_set'])} "
    again = [AGAIN] if any(map(too_few_runs, rows)) else []
    said = [_verdict(row, names[row["task"]]) for row in rows]
    return f"{line}instead of the twin: {ends}", [*(one[0].upper() + one[1:] for one in said), *again]


def came_out(rooms: Sequence[RoomPart], models: int, results: Sequence[Result], policies: int) -> str:
    """What went in, what came out and what it is worth, in a sentence; empty without pictures."""
    scenes = [scene for room in rooms for made in room.reconstructions for scene in made.scenes]
    checked = [scene.stable for scene in scenes if scene.stable is not None]
    text = f"{count(len(rooms), 'picture')} of {count(sum(room.objects for room in rooms), 'object')} went in; "
    text += count(len(scenes), "scene") + " of digital cousins" + f" from {count(models, 'model')}" * bool(models)
    text += f" ({sum(checked)} of {len(checked)} stand still in physics)" * bool(checked)
    text += f" and {'a policy' if policies == 1 else f'{policies} policies'}" * bool(policies)
    return "; ".join([f"{text} came out", *(each.gain for each in results if each.gain)]) * bool(rooms)


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
        about = f"success over {title_of(policies['assets'].iloc[0], split)} of families that no policy was trained on"
        label = f"{title(group)}: {about}, by kind of policy and training set; the numbers are in the table of assets"
        chart = success_chart(policies, label, rows, "task", float(skill.iloc[0]) if len(skill) else None)
        names = {task: kind(task, kinds) for task in policies["task"].unique()}
        found.append(Result(group, title(group), about, chart, *sentences(claims, names)))
    return found


def over_roles(cells: pd.DataFrame | None, claims: pd.DataFrame | None) -> list[Result]:
    """One for every row of the experiment with rollouts on the roles of Table 3, in the paper's order."""
    found = []
    judged = None if claims is None else claims[claims["over"] == "roles"]
    for task in sorted(cells["task"].unique(), key=task_key) if cells is not None else []:
        mine = cells[cells["task"] == task]  # type: ignore[index]
        label = f"{title(task)}: success by test asset and training set, with intervals; the numbers are in Table 3"
        roles = {name: title(name) for name in sorted(mine["test_asset"].unique(), key=set_key)}
        about, chart = "success of the policies by test asset", success_chart(mine, label, roles, "test_asset")
        group = str(mine["assets_of"].iloc[0])
        found.append(Result(group, title(task), about, chart, *sentences(judged, {task: title(task)})))
    return found
