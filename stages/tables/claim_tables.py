"""The paper's claims and the stability of training as tables."""

from typing import Any

import pandas as pd

from stages.config.tables import TablesConfig
from stages.tables.claims import COLLAPSED, HOLDS, MARGIN, MIN_RUNS, MIN_SPREAD_RUNS
from stages.tables.markup import NOT_RUN, Cell, Row, Table, number, percent, points, span
from stages.tables.order import title
from stages.tables.rows import records
from stages.tables.table3 import BASELINE

SENTENCES = {
    "equal": "On the twin itself, {ours} do as well as {theirs}",
    "unseen": "On unseen assets, {ours} do better than {theirs}",
    "flat": "From the twin to unseen assets, {ours} lose less than {theirs}",
    "steady": "{ours} differ less from run to run than {theirs}",
    "all": "On unseen assets, {ours} do better than {theirs}",
}


def sentence(row: dict[str, Any]) -> str:
    """A claim in words."""
    baseline = "the twin" if row["baseline"] == BASELINE else title(row["baseline"])
    sides = {"ours": f"policies trained on {title(row['training_set'])}", "theirs": f"those trained on {baseline}"}
    text = SENTENCES[row["claim"]].format(**sides)
    return text[0].upper() + text[1:]


def _sides(claim: str, ours: float, theirs: float) -> str:
    """The two numbers that a claim compares: rates, what is lost away from the twin, or deviations over runs."""
    if pd.isna(ours) or pd.isna(theirs):
        return ""
    if claim == "flat":
        return f"{points(ours)} against {points(theirs)}"
    if claim == "steady":
        return f"± {number(-100 * ours, 0)} against ± {number(-100 * theirs, 0)} points"
    return f"{percent(ours)} against {percent(theirs)}"


def over(row: dict[str, Any]) -> str:
    """The assets that a claim is judged over."""
    if row["over"] == BASELINE:
        return "the twin alone"
    return f"{row['assets']} {'held-out roles' if row['over'] == 'roles' else title(row['over'])}"


def why_open(row: dict[str, Any]) -> str:
    """Why nothing can be said, if it is for want of runs."""
    needed = MIN_SPREAD_RUNS if row["claim"] == "steady" else MIN_RUNS
    few = min(row["runs"], row["baseline_runs"])
    return "" if few >= needed else f"{few} run{'s' if few > 1 else ''} a side, {needed} needed"


def evidence(row: dict[str, Any]) -> str:
    """The difference with its interval; nothing if it cannot be computed (deviations of a single run)."""
    if pd.isna(row["difference"]):
        return "–"
    interval = f" [{span(row['low'], row['high'])}]" if row["low"] == row["low"] else ""
    return points(row["difference"]) + interval


def claims_table(table: pd.DataFrame, options: TablesConfig) -> Table:
    """Claim by claim what the paper says, and what this run says of it; `table` as `claims.answer` gives."""
    rows = []
    for row in records(table):
        paper = ""
        if pd.notna(row["published_ours"]):
            sides = _sides(row["claim"], row["published_ours"], row["published_theirs"])
            paper = f"{points(row['published_difference'])}, {sides}"
        rows.append(
            Row(
                [
                    Cell(title(row["task"])),
                    Cell(sentence(row)),
                    Cell(row["verdict"], why_open(row)),
                    Cell(evidence(row), _sides(row["claim"], row["ours"], row["theirs"]), paper),
                    Cell(over(row)),
                    Cell(f"{row['runs']} against {row['baseline_runs']}"),
                ],
                "holds" if row["verdict"] == HOLDS else "",
            )
        )
    return Table(
        name="table3_claims",
        caption="What the paper says of its policies, and whether these rollouts bear it out.",
        columns=["Task", "Claim", "Verdict", "Difference", "Judged over", "Runs"],
        rows=rows,
        headers=2,
        notes=[
            f"A claim holds if the {100 * options.confidence:g} % interval of the difference lies on its side, it does "
            "not hold if it lies on the other side; if it holds zero, nothing can be said. To do as well is to be no "
            f"more than {100 * MARGIN:g} points worse. Nothing is said of fewer than {MIN_RUNS} runs a side, of run to "
            f"run of fewer than {MIN_SPREAD_RUNS}.",
            "Unseen assets: the set of unseen assets where policies were rolled out on one, else the three held-out "
            "roles of Table 3, which are too few for most claims. Intervals: bootstrap over assets, their initial "
            f"states and runs, crossed ({options.bootstrap_samples} resamples, seed {options.seed}); of means never "
            "narrower than Newcombe's score interval with assets as units (on the twin alone: initial states). "
            "Deviations are sample ones over runs, pooled over the twin and unseen assets.",
        ],
    )


def stability_table(table: pd.DataFrame) -> Table:
    """How many runs collapsed and how runs differ; `table` as `claims.stability` gives."""
    rows = []
    for row in records(table):
        known = pd.notna(row["published_runs"])
        spread = [
            f"± {100 * row[name]:.0f} points" if pd.notna(row[name]) else "" for name in ("spread", "published_spread")
        ]
        collapsed = f"{row['collapsed']} of {row['runs']}" if pd.notna(row["collapsed"]) else NOT_RUN
        paper = f"{row['published_collapsed']} of {row['published_runs']}" if known else ""
        rows.append(
            Row(
                [
                    Cell(title(row["task"])),
                    Cell(title(row["training_set"])),
                    Cell(collapsed, published=paper),
                    Cell(spread[0], published=spread[1]),
                ]
            )
        )
    return Table(
        name="table3_stability",
        caption="How stable training is: collapsed runs, and how runs differ.",
        columns=["Task", "Training set", "Collapsed runs", "Spread over runs"],
        rows=rows,
        headers=2,
        notes=[
            "A run is collapsed if on the very assets it was trained on (the paper's: on the twin) it succeeds less "
            f"often than {100 * COLLAPSED:g} % of what the best run of its task does there. Spread: sample standard "
            "deviation over runs, pooled over the test assets."
        ],
    )
