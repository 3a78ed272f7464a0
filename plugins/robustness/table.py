"""Command `table`: robustness variants of Table 2, a row per perturbation and variant, mean and spread over seeds."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from roomkin.stages.contracts.policies import SceneScore
from roomkin.stages.tables.rows import ONE_SCENE, read_rows, records, title
from roomkin.stages.tables.table2 import AFFORDANCES, COUNTS, add_given, digits, first_rank, judge
from roomkin.stages.tables.table2 import METRICS as SCENE_METRICS
from roomkin.stages.tables.text import NOT_RUN, NOTHING, TextTable, cell, read_notes, spread, write

METRICS = [name for name in SCENE_METRICS if name != "l2_cm"]
SHAPES = ["chamfer", "shape_iou"]
PHYSICS = ["fallen", "shift_cm", "largest_shift_cm", "penetration_cm"]
MEASURES = [*COUNTS, "l2_cm", "worst_room_l2_cm", *METRICS, *PHYSICS, *SHAPES, *AFFORDANCES]
MOMENTS = [f"{name}_{moment}" for name in MEASURES for moment in ("mean", "std")]
COLUMNS = ["protocol", "variant", "judge", "n_draws", "n_rooms", "n_objects", "n_articulated", *MOMENTS]
AS_SHIPPED = "as shipped"


def _measure_draw(scores: pd.DataFrame) -> dict[str, float]:
    """The measures of one draw over the objects of all rooms."""
    cell = {name: scores[name].mean() for name in ("l2_cm", *METRICS, *SHAPES, "shift_cm")}
    cell |= {name: scores[name].eq(True).sum() for name in (*COUNTS, *AFFORDANCES)}
    cell["worst_room_l2_cm"] = scores.groupby("scene")["l2_cm"].mean().max()
    cell["fallen"] = scores["stable"].eq(False).sum()  # None is neither
    return cell | {"largest_shift_cm": scores["shift_cm"].max(), "penetration_cm": scores["penetration_cm"].max()}


def build(scores: pd.DataFrame, asked: Sequence[tuple[str, str]] = ()) -> pd.DataFrame:
    """One row per perturbation and variant with `COLUMNS`; empty if there is no such room.

    Args:
        scores: rows of `SceneScore`; rank 1 is used. Those without a perturbation are the first rows, `as shipped`.
        asked: pairs of perturbation and variant that get a row without figures where they were not run.

    Every figure is the mean over draws (seeds) of what a draw gives over the objects of all its rooms; counts, too.
    The standard deviation, a sample one, is over draws; there is none of one draw.
    """
    scores = first_rank(scores)
    rows: list[dict[str, Any]] = []
    if (scores["protocol"] != "").any():
        for (protocol, variant), group in scores.groupby(["protocol", "variant"], sort=False):
            draws = pd.DataFrame([_measure_draw(part) for _, part in group.groupby("draw")])
            row = {"protocol": protocol or AS_SHIPPED, "variant": variant, "judge": judge(group), "n_draws": len(draws)}
            row |= {"n_rooms": group["scene"].nunique(), "n_objects": len(group) // len(draws)}
            row["n_articulated"] = int(group["panels_correct"].notna().sum()) // len(draws)
            for name in MEASURES:
                row |= {f"{name}_mean": draws[name].mean(), f"{name}_std": draws[name].std()}
            rows.append(row)
    ran = {(row["protocol"], row["variant"]) for row in rows}
    pairs = [(protocol or AS_SHIPPED, variant) for protocol, variant in asked]
    rows += [{"protocol": name, "variant": variant} for name, variant in pairs if (name, variant) not in ran]
    rows.sort(key=lambda row: pairs.index((row["protocol"], row["variant"])) if pairs else 0)
    table = pd.DataFrame(rows, columns=COLUMNS)
    return table.astype({name: "Int64" for name in COLUMNS if name.startswith("n_")})


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
