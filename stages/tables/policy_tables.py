"""Table 3 as text, and what stands below tables of policies: what is pooled, what policies are given."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from roomkin.stages.config.tables import PolicyTables, TablesConfig
from roomkin.stages.contracts.errors import count
from roomkin.stages.plugins import shorten_name
from roomkin.stages.tables.cells import CELL
from roomkin.stages.tables.markup import TextTable, read_notes
from roomkin.stages.tables.methods import Kinds, kinds_of
from roomkin.stages.tables.order import CLOUDS, set_key, target_title, title
from roomkin.stages.tables.rows import records
from roomkin.stages.tables.scene_tables import format_confidence
from roomkin.stages.tables.text import NOT_RUN, cell, interval, number, percent


def policy_notes(options: PolicyTables) -> list[str]:
    """The notes of a run, as far as its options are known."""
    kinds, sensing = kinds_of(options), options.sensing
    pooled = [kinds.get(name, name) for name, about in options.policies.items() if (about.best or 0) > 1]
    simulator = shorten_name(sensing.simulator) if sensing else ""
    return read_notes("policies", pooled=pooled, sensing=sensing, starts=options.starts, simulator=simulator)


def _format_rate(row: dict[str, Any]) -> tuple[str, str]:
    """Value and remark of a cell of Table 3."""
    counts = f"{interval(row)} {row['successes']}/{row['episodes']}, {count(row['runs'], 'run')}"
    official = f"official {percent(row['official_successes'] / row['episodes'])}"
    steps = "" if pd.isna(row["steps"]) else f", {row['steps']:.0f} steps"
    return percent(row["mean"], row["std"]), f"{counts}, {official}{steps}"


def policies_table(
    table: pd.DataFrame,
    published: pd.DataFrame,
    options: TablesConfig,
    kinds: Kinds | None = None,
    notes: Sequence[str] = (),
) -> TextTable:
    """Table 3, laid out as in the paper: a row per test asset, a column per set.

    Args:
        table: as `table3.cells` gives.
        published: the paper's, beside ours (`methods.join_published`).
    """
    ours, theirs = ({tuple(row[name] for name in CELL): row for row in records(one)} for one in (table, published))
    every = theirs | ours
    sets, order = sorted({key[3] for key in every}, key=set_key), [key[:2] for key in (*ours, *theirs)]
    rows = []
    for of in sorted({key[:3] for key in every}, key=lambda of: (order.index(of[:2]), set_key(of[2]))):
        target, policy, asset = of
        ran = {name: ours[*of, name] for name in sets if (*of, name) in ours}
        first = next(iter(ran.values()), None)
        task = next(row["task"] for key, row in every.items() if key[:2] == of[:2])
        about = [(kinds or {}).get(policy, policy), CLOUDS[first["cloud"]]] if first else []
        line = [cell(target_title(target, task), "\n".join(about)), title(asset)]
        line.append(number(first["feature_distance"], 2) if first else "")
        for name in sets:
            paper = theirs.get((*of, name))
            missing = (NOT_RUN if paper or ran else "", "")
            value, remark = _format_rate(ran[name]) if name in ran else missing
            line.append(cell(value, remark, percent(paper["mean"], paper["std"]) if paper else ""))
        rows.append(line)
    return TextTable(
        name="table3",
        caption="Table 3: success of policies by training set (columns) and test asset (rows).",
        columns=["Task", "Test asset", "Distance", *(title(name) for name in sets)],
        rows=rows,
        headers=2,
        notes=[*read_notes("table3", confidence=format_confidence(options)), *notes],
    )
