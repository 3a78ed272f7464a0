"""Table 2 as text."""

from typing import Any

import pandas as pd

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts.cousins import NO_MODEL
from roomkin.stages.tables.rows import NO_IMAGE, VARIANTS, records, title
from roomkin.stages.tables.table2 import AFFORDANCES, COUNTS, METRICS
from roomkin.stages.tables.text import NOT_RUN, NOTHING, TextTable, cell, number, read_notes, spread

# Decimals of a measure by its unit.
DIGITS = {"cm": 1, "rad": 2, "iou": 2}


def digits(measure: str) -> int:
    """Decimals of a measure; counts and percentages have as many as centimetres."""
    return DIGITS.get(measure.rpartition("_")[2], DIGITS["cm"])


def format_confidence(options: TablesConfig) -> str:
    """'95 %'."""
    return f"{100 * options.confidence:g} %"


def add_given(table: pd.DataFrame) -> list[str]:
    """What every row knows before any picture is compared, and the row that judges are read against."""
    stand_in = table["judge"].astype(str).str.contains(NO_MODEL).any()
    return read_notes("given", baseline=NO_IMAGE if NO_IMAGE in set(table["variant"]) else "", stand_in=stand_in)


def _scores(row: dict[str, Any]) -> list[str]:
    """The result cells of a row of Table 2."""
    ran, objects, theirs = row["status"] == "run", row["n_objects"], row["published_n_objects"]
    known = pd.notna(theirs)
    cells = [cell(str(objects), published=str(theirs) if known else "") if ran else NOT_RUN]
    for name in COUNTS:
        published = f"{row[f'published_{name}']}/{theirs}" if known else ""
        cells.append(cell(f"{row[name]}/{objects}" if ran else "", published=published))
    for metric in METRICS:
        mean, std, low, high = (row.get(f"{metric}_{end}") for end in ("mean", "std", "low", "high"))
        value = spread(mean, std, digits(metric)) or NOTHING if ran else ""
        ends = [number(end, digits(metric)) for end in (low, high)]
        paper = [row.get(f"published_{metric}_{moment}") for moment in ("mean", "std")]
        interval = f"[{', '.join(ends)}]" if ran and all(ends) else ""
        cells.append(cell(value, interval, spread(paper[0], paper[1], DIGITS["iou"])))
    shape = spread(row["shape_iou_mean"], row["shape_iou_std"], DIGITS["iou"]) or NOTHING
    opens = ", ".join(str(row[name]) for name in AFFORDANCES) + f" of {row['n_articulated']}"
    return [*cells, cell(shape, opens if row["n_articulated"] else "") if ran else ""]


def scenes_table(table: pd.DataFrame, options: TablesConfig) -> TextTable:
    """Table 2, laid out as in the paper."""
    rows = []
    for row in records(table):
        judge = row["judge"] if row["status"] == "run" else ""
        rows.append([title(row["scene"]), f"({row['variant']})", judge, number(row["scale_m"], 2), *_scores(row)])
    return TextTable(
        name="table2",
        caption="Table 2: scene reconstruction in the sim-to-sim setting, scenes of nearest cousins.",
        columns=["Scene", "Variant", "Judge", "Scale (m)", "Objects", "Category", "Model", "L2 (cm)", "Ori. (rad)",
                 "Ori., paper's count", "Box IoU", "Oriented IoU", "Shape IoU; panels, handles, hinges"],
        rows=rows,
        headers=3,
        notes=[*read_notes("table2", confidence=format_confidence(options), variants=VARIANTS), *add_given(table)],
    )  # fmt: skip
