"""The results of the policies: charts of success with intervals, and what cousins brought, in a sentence each."""

import base64
import io
import math
from textwrap import fill
from typing import Any, NamedTuple

import pandas as pd
from markupsafe import Markup
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

from roomkin.plugins.claims.claims import FAILS, HOLDS
from roomkin.plugins.claims.tables import count_lacking_runs, evidence, title_of
from roomkin.stages.contracts.errors import count
from roomkin.stages.tables.figures import GREY, color, marker, style
from roomkin.stages.tables.policy_tables import Kinds
from roomkin.stages.tables.rows import SKILL, records, set_key, target_title, title
from roomkin.stages.tables.table2 import TOTAL
from roomkin.stages.tables.text import number, percent

Points = list[tuple[float, float]]

SERIES = ("all", "cousins_8", "cousins_4", "twin")  # colors of lines that are not training sets


def embed_svg(svg: bytes, alt: str) -> Markup:
    """An SVG file as a picture of the page."""
    source = base64.b64encode(svg).decode("ascii")
    return Markup('<img class="chart" src="data:image/svg+xml;base64,{}" alt="{}">').format(source, alt)


def _draw_figure(figure: Figure, alt: str) -> Markup:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    plt.close(figure)
    return embed_svg(buffer.getvalue(), alt)


def line_chart(series: dict[str, Points], x_label: str, alt: str) -> Markup:
    """A small line chart with a legend.

    Args:
        series: name -> (x, y) points; points that are not finite are left out.
        alt: what the chart shows, for screen readers.
    """
    lines = {name: [p for p in points if all(map(math.isfinite, p))] for name, points in series.items()}
    if not any(lines.values()):
        return Markup("")
    with style():
        figure, axes = plt.subplots(figsize=(3.6, 2.3), layout="constrained")
        for (name, points), key in zip(lines.items(), SERIES * len(lines), strict=False):
            line = "o" if len(points) == 1 else "-"
            axes.plot(*zip(*points, strict=True), line, color=color(key), linewidth=1.6, label=name.replace("_", " "))
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.yaxis.set_major_locator(MaxNLocator(5))
        axes.set_xlabel(x_label)
        figure.legend(loc="outside upper left", ncols=3)
        return _draw_figure(figure, alt)


def success_chart(cells: pd.DataFrame, alt: str, rows: dict[str, str], by: str, skill: float | None = None) -> Markup:
    """Success (`cells` as `cells.rates` gives) with intervals: lines of the column `by`, training sets as colors.

    Counts stand at the right, so that the chart can be read without the table.

    Args:
        rows: value of the column `by` -> what it is called, from top to bottom.
        skill: success of the scripted skill, drawn as a line across.
    """
    sets, names = sorted(cells["training_set"].unique(), key=set_key), list(rows)
    with style():
        figure, axes = plt.subplots(figsize=(4.4, 0.75 + 0.2 * len(rows) * (len(sets) + 0.9)), layout="constrained")
        step = 0.62 / max(len(sets), 1)
        for index, name in enumerate(sets):
            mine = cells[cells["training_set"] == name]
            places = mine[by].map(names.index) + step * (index - (len(sets) - 1) / 2)
            bars = [100 * (mine["mean"] - mine["low"]).clip(0), 100 * (mine["high"] - mine["mean"]).clip(0)]
            axes.errorbar(
                100 * mine["mean"], places, xerr=bars, fmt=marker(name), color=color(name), markersize=5.5,
                elinewidth=2, capsize=0, clip_on=False, label=f"trained on {title(name)}",
            )  # fmt: skip
            for place, successes, episodes in zip(places, mine["successes"], mine["episodes"], strict=True):
                axes.text(106, place, f"{successes}/{episodes}", va="center", size=7.5, color=color(name))
        if skill is not None:
            axes.axvline(100 * skill, color=GREY, linestyle="--", linewidth=1, clip_on=False, label=title(SKILL))
        axes.set_yticks(range(len(rows)), list(rows.values()))
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlim(0, 100)
        axes.xaxis.set_major_formatter(PercentFormatter(decimals=0))
        axes.grid(False, axis="y")
        axes.tick_params(axis="y", length=0)
        figure.legend(loc="outside upper left", ncols=2)
        return _draw_figure(figure, alt)


class Result(NamedTuple):
    """The result of a target, or of one policy on it: a chart, a headline and sentences on what cousins brought."""

    target: str
    title: str
    about: str
    chart: Markup
    gain: str
    verdicts: list[str]


AGAIN = Markup(
    "The intervals are over assets and starts, for these policies alone. With one seed nothing can be said about "
    "training again: set <code>experiment: {seeds: [0, 1]}</code>."
)


def describe_rooms(table: pd.DataFrame | None) -> str:
    """How well rooms are rebuilt, in words, by the total of the first variant in Table 2; empty: not scored."""
    totals = records(table[table["scene"] == TOTAL]) if table is not None else []
    if not totals:
        return ""
    row = totals[0]
    low, high = (number(row[f"l2_cm_{end}"], 1) for end in ("low", "high"))
    ends = f" (interval {low} to {high})" if low else ""
    return (
        f"{row['category_correct']} of {row['n_objects']} objects have the right category, and they stand "
        f"{number(row['l2_cm_mean'], 1)} cm{ends} from their true places"
    )


def _verdict(row: dict[str, Any], name: str) -> str:
    """The difference, its interval, and what it says of training."""
    text = f"{name}: {evidence(row)} with {title(row['training_set'])} instead of the twin"
    seeds = f"over {row['runs']} and {row['baseline_runs']} seeds of training"
    verdict = (
        f"that cousins help {row['verdict']}"
        if row["verdict"] in (HOLDS, FAILS)
        else "whether cousins help cannot be said"
    )
    return f"{text}, {seeds}: {verdict}."


def sentences(claims: pd.DataFrame | None, target: str, names: dict[str, str]) -> tuple[str, list[str]]:
    """What cousins brought on unseen assets of a target in a line, and in a sentence for each policy of `names`."""
    rows = records(claims.query("target == @target and claim == 'unseen'")) if claims is not None else []
    rows = [row for row in rows if row["policy"] in names]
    if not rows:
        return "", []
    first = rows[0]
    over = title_of(first["assets"], "held-out roles" if first["over"] == "roles" else first["over"])
    what = target_title(first["target"], first["task"])
    line = (
        f"{what} on {over} succeeds {percent(first['ours'])} of the time after training on "
        f"{title(first['training_set'])}, {percent(first['theirs'])} after training on the twin: {evidence(first)}"
    )
    if count_lacking_runs(first):
        runs = count(min(first["runs"], first["baseline_runs"]), "training")
        line += f"; {runs} a side, and another may turn out otherwise"
    again = [AGAIN] if any(map(count_lacking_runs, rows)) else []
    verdicts = [_verdict(row, names[row["policy"]]) for row in rows if not count_lacking_runs(row)]
    return line, [*(one[0].upper() + one[1:] for one in verdicts), *again]


def compare_over_assets(table: pd.DataFrame | None, claims: pd.DataFrame | None, kinds: Kinds) -> list[Result]:
    """A result for every target with unseen assets, over its first set; `table` as `assets.build` gives."""
    found = []
    for target, mine in table.groupby("target", sort=False) if table is not None else ():
        policies = mine[mine["training_set"] != SKILL]
        if policies.empty:
            continue
        split = policies["test_asset"].iloc[0]
        policies = policies[policies["test_asset"] == split]
        skill = mine[(mine["training_set"] == SKILL) & (mine["test_asset"] == split)]["mean"]
        names = {policy: kinds.get(policy, policy) for policy in policies["policy"].unique()}
        name = target_title(str(target), policies["task"].iloc[0])
        about = f"success over {title_of(policies['assets'].iloc[0], split)} of families that no policy was trained on"
        label = f"{name}: {about}, by kind of policy and training set; the numbers are in the table of assets"
        rows = {policy: fill(text, 24) for policy, text in names.items()}
        chart = success_chart(policies, label, rows, "policy", float(skill.iloc[0]) if len(skill) else None)
        found.append(Result(str(target), name, about, chart, *sentences(claims, str(target), names)))
    return found


def compare_over_roles(cells: pd.DataFrame | None, claims: pd.DataFrame | None, kinds: Kinds) -> list[Result]:
    """A result for every target and policy with rollouts on the roles of Table 3."""
    found = []
    judged = None if claims is None else claims.query("over == 'roles'")
    for (target, policy), mine in cells.groupby(["target", "policy"], sort=False) if cells is not None else ():
        of_target = target_title(str(target), mine["task"].iloc[0])
        name = f"{of_target}, {kinds.get(str(policy), policy)}"
        label = f"{name}: success by test asset and training set, with intervals; the numbers are in Table 3"
        roles = {name: title(name) for name in sorted(mine["test_asset"].unique(), key=set_key)}
        about, chart = "success of the policies by test asset", success_chart(mine, label, roles, "test_asset")
        texts = sentences(judged, str(target), {str(policy): name})
        found.append(Result(str(target), name, about, chart, *texts))
    return found
