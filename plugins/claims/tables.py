"""Tables of policies beside Table 3 as text: unseen assets, claims, stability of training."""

from collections.abc import Callable, Sequence
from typing import Any

import pandas as pd

from roomkin.plugins.claims import power
from roomkin.plugins.claims.claims import COLLAPSED, MIN_RUNS, MIN_SPREAD_RUNS, NOT_WORSE
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts.errors import count
from roomkin.stages.tables.policy_tables import Kinds
from roomkin.stages.tables.rows import CLOUDS, SKILL, records, row_title, set_key, target_title, title
from roomkin.stages.tables.table2 import format_confidence
from roomkin.stages.tables.table3 import BASELINE, RANDOMISED
from roomkin.stages.tables.text import NOT_RUN, NOTHING, TextTable, cell, interval, number, percent, points, read_notes

PACKAGE = "roomkin.plugins.claims"  # has their notes
SENTENCES = {
    "equal": "On the twin itself, {ours} do as well as {theirs}",
    "unseen": "On unseen assets, {ours} do better than {theirs}",
    "flat": "From the twin to unseen assets, {ours} lose less than {theirs}",
    "steady": "{ours} differ less from run to run than {theirs}",
    "randomised": "On unseen assets, {ours} do better than {theirs}",
    "all": "On unseen assets, {ours} do better than {theirs}",
}
MINUS = {"twin": "minus the twin's", "randomised": "minus the randomised twin's", "network": "minus {own}"}
Line = dict[str, dict[str, Any]]  # training set -> row of a frame


def _lines(table: pd.DataFrame, by: list[str]) -> list[tuple[tuple[Any, ...], Line]]:
    """Rows that agree in `by`, their training sets side by side, in the order in which they stand."""
    groups = table.groupby(by, sort=False)
    return [(key, {row["training_set"]: row for row in records(group)}) for key, group in groups]


def _side_by_side(head: list[str], line: Line, sets: list[str], text: Callable[[dict[str, Any]], str]) -> list[str]:
    return [*head, *(text(line[name]) if name in line else "" for name in sets)]


def _rate(row: dict[str, Any]) -> str:
    remark = f"{interval(row)} {count(row['assets'], 'asset')}, {count(row['runs'], 'run')}"
    return cell(percent(row["mean"], row["std"]), remark)


def _gain(versus: str) -> Callable[[dict[str, Any]], str]:
    """The text of a difference, empty if there is none; `versus`: one of `MINUS`."""

    def text(row: dict[str, Any]) -> str:
        difference = row[f"{versus}_difference"]
        return "" if pd.isna(difference) else cell(points(difference), interval(row, f"{versus}_"))

    return text


def _group(table: pd.DataFrame, sets: list[str], kinds: Kinds) -> list[list[str]]:
    """The rows of one group and set of assets: rates, minus those of `MINUS`, the skill."""
    first = records(table)[0]
    about = f"{count(first['assets'], 'asset')} of {count(first['families'], 'family', 'families')}, "
    about += count(first["places"], "initial state")
    about += f", {CLOUDS['object']}" * (first["cloud"] == "object")
    group = cell(f"{target_title(first['target'], first['task'])}, {title(first['test_asset'])}", about)
    lines = _lines(table[table["training_set"] != SKILL], ["policy"])
    policies = [(kinds.get(name, name), line) for (name,), line in lines]
    rows = [_side_by_side([group, name], line, sets, _rate) for name, line in policies]
    for versus, what in MINUS.items():
        minus = what.format(own=kinds.get(first["policy"], first["policy"]))
        gains = [_side_by_side([group, f"{name}, {minus}"], line, sets, _gain(versus)) for name, line in policies]
        rows += [row for row in gains if any(row[2:])]
    for row in records(table[table["training_set"] == SKILL]):
        counts = f"{interval(row)} {row['successes']}/{row['episodes']}; a reference, not a policy"
        rows.append([group, cell(f"{title(SKILL)}: {percent(row['mean'])}", counts), *[""] * len(sets)])
    return rows


def assets_table(
    table: pd.DataFrame, options: TablesConfig, kinds: Kinds | None = None, notes: Sequence[str] = ()
) -> TextTable:
    """Success over unseen assets; `table` as `assets.build` gives, `kinds` as `kinds_of`, `notes` as `policy_notes`."""
    sets = sorted({*table["training_set"]} - {SKILL}, key=set_key) or [BASELINE]
    groups = [group for _, group in table.groupby(["target", "test_asset"], sort=False)]
    return TextTable(
        name="assets",
        caption="Success over unseen assets by kind of policy (rows) and training set (columns), [intervals].",
        columns=["Assets", "Policies", *(title(name) for name in sets)],
        rows=[row for group in groups for row in _group(group, sets, kinds or {})],
        headers=2,
        notes=[*read_notes("assets", PACKAGE, confidence=format_confidence(options), options=options), *notes],
    )


def by_handle_table(table: pd.DataFrame, options: TablesConfig) -> TextTable:
    """The same by kind and length of the handle; `table` as `assets.by_handle` gives."""
    skill, sets = table["training_set"] == SKILL, sorted({*table["training_set"]}, key=set_key)
    policy_of = table.drop_duplicates("target").set_index("target")["policy"]
    table = table.assign(policy=table["policy"].mask(skill, table["target"].map(policy_of)))  # beside a policy
    rows = []
    for (_, _, split, _, handle), line in _lines(table, ["target", "policy", "test_asset", "by", "handle"]):
        first = next(iter(line.values()))
        head = [cell(row_title(first), title(split)), cell(handle, f"n = {first['assets']}")]
        rows.append(_side_by_side(head, line, sets, _rate))
    return TextTable(
        name="assets_by_handle",
        caption="Success over unseen assets, by kind and length of the handle.",
        columns=["Policy", "Handle", *(title(name) for name in sets)],
        rows=rows,
        headers=2,
        notes=[f"n: assets. Intervals ({format_confidence(options)}) as in the table over all assets."],
    )


def title_of(number: int, name: str) -> str:
    """A number of assets or roles with their title: '24 unseen assets', '1 unseen asset'."""
    text = title(name)
    return f"{number} {text if number != 1 else text.replace('assets', 'asset').replace('roles', 'role')}"


def claim_sentence(row: dict[str, Any]) -> str:
    """A claim in words."""
    baseline = {BASELINE: "the twin", RANDOMISED: "the twin, randomised"}.get(row["baseline"], title(row["baseline"]))
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


def _describe_judged(row: dict[str, Any]) -> str:
    if row["over"] == BASELINE:
        return "the twin alone"
    return title_of(row["assets"], "unseen" if row["over"] == "roles" else row["over"])


def count_lacking_runs(row: dict[str, Any]) -> str:
    """How many runs are lacking to judge a claim; empty: none."""
    needed = MIN_SPREAD_RUNS if row["claim"] == "steady" else MIN_RUNS
    few = min(row["runs"], row["baseline_runs"])
    return "" if few >= needed else f"{count(few, 'run')} a side, {needed} needed to judge"


def describe_shown(row: dict[str, Any]) -> str:
    """The smallest effect that a claim can show with its assets, starts and runs."""
    if row["claim"] == "equal":
        return "" if row["shows"] == 0 else "could not hold even if nobody ever failed"
    if pd.isna(row["shows"]):
        return "could show no effect"
    return f"could show {100 * row['shows']:.0f} points"


def evidence(row: dict[str, Any]) -> str:
    """The difference of a claim with its interval; deviations of a single run have none."""
    if pd.isna(row["difference"]):
        return NOTHING
    return points(row["difference"]) + (f" {interval(row)}" if pd.notna(row["low"]) else "")


def claims_table(table: pd.DataFrame, options: TablesConfig) -> TextTable:
    """The paper's claims with the verdicts of this run; `table` as `claims.answer` gives."""
    rows = []
    for row in records(table):
        paper = ""
        if pd.notna(row["published_ours"]):
            sides = _sides(row["claim"], row["published_ours"], row["published_theirs"])
            paper = f"{points(row['published_difference'])}, {sides}"
        few, sides = count_lacking_runs(row), _sides(row["claim"], row["ours"], row["theirs"])
        difference = cell(evidence(row), sides + ", of these policies" * bool(few and sides), paper)
        verdict, runs = (
            cell(row["verdict"], few or describe_shown(row)),
            f"{row['runs']} against {row['baseline_runs']}",
        )
        rows.append([row_title(row), claim_sentence(row), verdict, difference, _describe_judged(row), runs])
    return TextTable(
        name="table3_claims",
        caption="Claims about policies (the paper's, and cousins against a randomised twin), and what rollouts say.",
        columns=["Policy", "Claim", "Verdict", "Difference", "Judged over", "Runs"],
        rows=rows,
        headers=2,
        notes=read_notes(
            "claims", PACKAGE, confidence=format_confidence(options), options=options, not_worse=NOT_WORSE,
            min_runs=MIN_RUNS, min_spread_runs=MIN_SPREAD_RUNS, power=power,
        ),
    )  # fmt: skip


def stability_table(table: pd.DataFrame) -> TextTable:
    """How many runs collapsed and how runs differ; `table` as `claims.stability` gives."""
    rows = []
    for row in records(table):
        spreads = (row["spread"], row["published_spread"])
        ours, theirs = (f"± {100 * one:.0f} points" if pd.notna(one) else "" for one in spreads)
        collapsed = f"{row['collapsed']} of {row['runs']}" if pd.notna(row["collapsed"]) else NOT_RUN
        known = pd.notna(row["published_runs"])
        paper = f"{row['published_collapsed']} of {row['published_runs']}" if known else ""
        rows.append([row_title(row), title(row["training_set"]), cell(collapsed, "", paper), cell(ours, "", theirs)])
    return TextTable(
        name="table3_stability",
        caption="Stability of training: collapsed runs, and spread over runs.",
        columns=["Policy", "Training set", "Collapsed runs", "Spread over runs"],
        rows=rows,
        headers=2,
        notes=read_notes("stability", PACKAGE, collapsed=COLLAPSED),
    )
