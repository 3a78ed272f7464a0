"""Shares of things that are right, with intervals over models: every model counts alike."""

from collections.abc import Iterator

import pandas as pd

from roomkin.stages.config.tables import TablesConfig
from roomkin.stages.tables.intervals import (
    Side,
    difference_interval,
    pair_sides,
    rate_interval,
    rate_of,
    side_of,
)

OPTIONS = TablesConfig()


def side_of_things(rows: pd.DataFrame, measure: str) -> Side:
    """Rows as the project's bootstrap takes them: a family per model, a place per object.

    Args:
        rows: of things, with columns `model`, `picture`, `number` and the measure (NaN or None: not asked).
    """
    known = rows.dropna(subset=[measure])
    table = pd.DataFrame(
        {
            "run": "all",
            "seed": 0,
            "checkpoint": "all",
            "family": known["model"],
            "asset": known["model"],
            "initial_state": known["picture"] + "/" + known["number"].astype(str),
            "success": known[measure].astype(float),
        }
    )
    return side_of(table)


def share(rows: pd.DataFrame, measure: str) -> str:
    """Share of rows that are right, in percent, with its interval; every model counts alike. Empty: none is asked."""
    side = side_of_things(rows, measure)
    if side.empty:
        return ""
    low, high = rate_interval(side, OPTIONS)
    return f"{100 * rate_of(side):.0f} [{100 * low:.0f}, {100 * high:.0f}]"


def compare_shares(ours: pd.DataFrame, theirs: pd.DataFrame, measure: str) -> str:
    """Ours less theirs in percentage points, with its interval, over the things that both were asked."""
    one, other = pair_sides(*(side_of_things(rows, measure) for rows in (ours, theirs)))
    if one.empty:
        return ""
    low, high = difference_interval(one, other, OPTIONS)
    apart = 100 * (rate_of(one) - rate_of(other))
    return f"{apart:+.0f} [{100 * low:+.0f}, {100 * high:+.0f}] of {one.shape[1]}"


def table(heading: list[str], lines: Iterator[list[str]]) -> str:
    """A table in Markdown."""
    return "\n".join(["| " + " | ".join(line) + " |" for line in [heading, ["---"] * len(heading), *lines]]) + "\n"
