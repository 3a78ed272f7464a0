"""Command `table`: the companion of Table 2, from the scores of generated scenes."""

from pathlib import Path
from typing import Any

import pandas as pd

from roomkin.plugins.robustness.rows import build
from roomkin.stages.contracts.policies import SceneScore
from roomkin.stages.tables.markup import TextTable, read_notes
from roomkin.stages.tables.order import title
from roomkin.stages.tables.rows import ONE_SCENE, read_rows, records
from roomkin.stages.tables.scene_tables import add_given, digits
from roomkin.stages.tables.table2 import AFFORDANCES, COUNTS
from roomkin.stages.tables.text import NOT_RUN, NOTHING, cell, spread
from roomkin.stages.tables.writing import write

ROBUST = ["l2_cm", "worst_room_l2_cm", "orientation_rad", "oriented_iou", "fallen", "largest_shift_cm"]
ROBUST += ["penetration_cm", "chamfer", "shape_iou"]


def robustness_table(table: pd.DataFrame) -> TextTable:
    """The companion of Table 2: the robustness variants of the rooms."""
    columns = ["Rooms", "Variant", "Judge", "Draws × objects", "Category", "Model", "L2 (cm)", "L2, worst room",
               "Ori. (rad)", "Oriented IoU", "Fallen", "Largest shift (cm)", "Penetration (cm)", "Chamfer (%)",
               "Shape IoU", "Panels, handles, hinges"]  # fmt: skip
    rows = []
    names = list(dict.fromkeys(table["protocol"]))
    for row in sorted(records(table), key=lambda row: names.index(row["protocol"])):  # variants together
        head = [title(row["protocol"]), f"({row['variant']})"]
        if pd.isna(row["n_draws"]):
            rows.append([*head, "", NOT_RUN, *[""] * len(columns[len(head) + 2 :])])
            continue
        cells = [row["judge"], f"{row['n_draws']} × {row['n_objects']}"]
        cells += [f"{_format_draws(row, name)} of {row['n_objects']}" for name in COUNTS]
        cells += [_format_draws(row, name) or NOTHING for name in ROBUST]
        panels = ", ".join(_format_draws(row, name) for name in AFFORDANCES)
        cells.append(cell(panels if row["n_articulated"] else NOTHING, f"of {row['n_articulated']}"))
        rows.append([*head, *cells])
    return TextTable(
        name="table2_robustness",
        caption="Beside Table 2: robustness variants of the same rooms.",
        columns=columns,
        rows=rows,
        headers=3,
        notes=[*read_notes("robustness", "roomkin.plugins.robustness"), *add_given(table)],
    )


def _format_draws(row: dict[str, Any], name: str) -> str:
    factor = 100 if name == "chamfer" else 1
    return spread(factor * row[f"{name}_mean"], factor * row[f"{name}_std"], digits(name))


def run(*, out: Path, scores: tuple[Path, ...] = ()) -> None:
    """Write table2_robustness (.csv, .html, .tex).

    Args:
        out: folder to write into.
        scores: scores.csv files of generated scenes.
    """
    companion = build(read_rows(SceneScore, scores, ONE_SCENE))
    write(out, "table2_robustness", companion, [robustness_table(companion)])
