"""The scores of a submission: shares with intervals over models, a line for the table of all."""

from dataclasses import fields

import pandas as pd

from roomkin.plugins.scorecard.scoring import RoomRow, ThingRow
from roomkin.plugins.scorecard.shares import compare_shares, share, table
from roomkin.plugins.scorecard.submission import About

MEASURES = ["placed", "sensible", "size", "place", "facing", "carrier", "clear", "stands", "opens", "handle"]
HEADING = ["method", "given beside the picture", "rooms", "things", *MEASURES, "*clear* and *stands* by",
           "L2 of what is placed, median (cm)",
           "IoU of boxes, median", "IoU of shapes, median (of)", "extra things"]  # fmt: skip


def frame_things(things: list[ThingRow]) -> pd.DataFrame:
    """Rows of things as a table."""
    return pd.DataFrame(things, columns=[field.name for field in fields(ThingRow)])


def frame_rooms(rooms: list[RoomRow]) -> pd.DataFrame:
    """Rows of rooms as a table."""
    return pd.DataFrame(rooms, columns=[field.name for field in fields(RoomRow)])


def make_line(about: About, things: pd.DataFrame, rooms: pd.DataFrame) -> list[str]:
    """The cells of a submission's line, below `HEADING`."""
    shapes = pd.to_numeric(things["shape"]).dropna()
    return [
        _plain(about.method),
        ", ".join(about.given) or "nothing",
        f"{int((rooms['placed'] > 0).sum())} of {len(rooms)}",
        str(len(things)),
        *(share(things, measure) for measure in MEASURES),
        describe_shapes(things),
        _median(things["off_place_cm"], 1),
        _median(things["iou"], 2),
        f"{shapes.median():.2f} ({len(shapes)})" if len(shapes) else "",
        str(int(rooms["extra"].sum())),
    ]


def describe_shapes(things: pd.DataFrame) -> str:
    """What stands for the things: boxes, meshes, or so many of either."""
    meshes, placed = int(things["shaped"].sum()), int(things["placed"].sum())
    return "boxes" if not meshes else "meshes" if meshes == placed else f"{meshes} meshes, {placed - meshes} boxes"


def make_table(lines: list[list[str]]) -> str:
    """The table of submissions in Markdown."""
    return table(HEADING, iter(lines))


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
