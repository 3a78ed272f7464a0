"""Robustness variants of Table 2's rooms: a row per perturbation and variant, mean and spread over its seeds."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from roomkin.stages.tables.table2 import AFFORDANCES, COUNTS, first_rank, judge
from roomkin.stages.tables.table2 import METRICS as SCENE_METRICS

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
