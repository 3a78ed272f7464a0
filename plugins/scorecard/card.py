"""The scores of a submission: shares with intervals over models, a line for the table of all."""

from collections.abc import Iterable, Sequence
from dataclasses import fields

import pandas as pd

from roomkin.plugins.scorecard.scoring import RoomRow, ThingRow
from roomkin.plugins.scorecard.truth import About
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.tables.intervals import Side, difference_interval, pair_sides, rate_interval, rate_of, side_of

OPTIONS = TablesConfig()


def side_of_things(rows: pd.DataFrame, measure: str) -> Side:
    """Rows as the project's bootstrap takes them: a family per model, a place per object.

    Args:
        rows: of things, with columns `model`, `picture`, `number` and the measure (NaN or None: not asked).
    """
    known = rows.dropna(subset=[measure])
    table = pd.DataFrame(
        {
            "run": "all", "seed": 0, "checkpoint": "all", "family": known["model"], "asset": known["model"],
            "initial_state": known["picture"] + "/" + known["number"].astype(str),
            "success": known[measure].astype(float),
        }
    )  # fmt: skip
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


def table(heading: list[str], lines: Iterable[list[str]]) -> str:
    """A table in Markdown."""
    return "\n".join(["| " + " | ".join(line) + " |" for line in [heading, ["---"] * len(heading), *lines]]) + "\n"


MEASURES = ["placed", "sensible", "size", "place", "facing", "carrier", "clear", "stands", "opens", "handle"]
HEADING = ["method", "given beside the picture", "rooms", "things", *MEASURES, "*clear* and *stands* by",
           "L2 of what is placed, median (cm)",
           "IoU of boxes, median", "IoU of shapes, median (of)", "extra things"]  # fmt: skip


def make_frame(rows: Sequence[ThingRow | RoomRow], kind: type[ThingRow | RoomRow]) -> pd.DataFrame:
    """Rows of things or of rooms as a table."""
    return pd.DataFrame(rows, columns=[field.name for field in fields(kind)])


def make_line(about: About, things: pd.DataFrame, rooms: pd.DataFrame) -> list[str]:
    """The cells of a submission's line, below `HEADING`."""
    shapes = pd.to_numeric(things["shape"]).dropna()
    return [
        _plain(about.method), ", ".join(about.given) or "nothing",
        f"{int((rooms['placed'] > 0).sum())} of {len(rooms)}", str(len(things)),
        *(share(things, measure) for measure in MEASURES), describe_shapes(things), _median(things["off_place_cm"], 1),
        _median(things["iou"], 2), f"{shapes.median():.2f} ({len(shapes)})" if len(shapes) else "",
        str(int(rooms["extra"].sum())),
    ]  # fmt: skip


def describe_shapes(things: pd.DataFrame) -> str:
    """What stands for the things: boxes, meshes, or so many of either."""
    meshes, placed = int(things["shaped"].sum()), int(things["placed"].sum())
    return "boxes" if not meshes else "meshes" if meshes == placed else f"{meshes} meshes, {placed - meshes} boxes"


def compare(ours: pd.DataFrame, theirs: pd.DataFrame) -> str:
    """Two submissions, thing by thing: one less the other in points, by measure, with its interval over models."""
    return table(["measure", "difference in points [95 %] of things"],
                 ([measure, compare_shares(ours, theirs, measure)] for measure in MEASURES))  # fmt: skip


def _median(values: "pd.Series[float]", digits: int) -> str:
    known = pd.to_numeric(values).dropna()
    return f"{known.median():.{digits}f}" if len(known) else ""


def _plain(text: str) -> str:
    """A text that cannot break out of a cell of a table."""
    return " ".join(text.replace("|", "/").replace("<", "(").replace(">", ")").split())
