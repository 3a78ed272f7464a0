"""Table 2: how well the scenes of nearest cousins match the rooms they were made from (paper B.1)."""

from typing import Any

import numpy as np
import pandas as pd

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts.cousins import NO_MODEL
from roomkin.stages.tables.intervals import t_interval
from roomkin.stages.tables.rows import DEFAULT, NO_IMAGE, VARIANTS, records, sort_key, title
from roomkin.stages.tables.text import NOT_RUN, NOTHING, TextTable, cell, number, read_notes, spread

METRICS = ["l2_cm", "orientation_rad", "orientation_paper_rad", "iou", "oriented_iou"]
MEASURES = [*METRICS, "chamfer", "shape_iou", "shift_cm", "penetration_cm"]
COUNTS = ["category_correct", "model_correct"]
AFFORDANCES = ["panels_correct", "handle_correct", "hinge_correct"]  # of placed objects whose true model opens
MOMENTS = [f"{metric}_{moment}" for metric in METRICS for moment in ("mean", "std")]
PUBLISHED_MOMENTS = [name for name in MOMENTS if not name.startswith("orientation_rad")]
COLUMNS = ["scene", "scale_m", "variant", "judge", "n_objects", *COUNTS, *MOMENTS]
INTERVALS = ["l2_cm_low", "l2_cm_high", "iou_low", "iou_high"]
PUBLISHED = [f"published_{name}" for name in ["n_objects", *COUNTS, *PUBLISHED_MOMENTS]]
ORIENTED = ["n_oriented", "n_oriented_paper"]
COUSINS = ["shape_iou_mean", "shape_iou_std", "n_shapes", *AFFORDANCES, "n_articulated"]  # what a cousin is for
ALL_COLUMNS = [*COLUMNS, *INTERVALS, *COUSINS, "n_scenes", "n_placed", *ORIENTED, "n_stable", *PUBLISHED, "status"]
TOTAL = "total"


def _measure_scores(scores: pd.DataFrame, confidence: float) -> dict[str, Any]:
    """Counts, means and intervals over the true objects in `scores` (one row per object)."""
    found: dict[str, Any] = {"status": "run", "judge": judge(scores), "n_scenes": scores["scene"].nunique()}
    found |= {"n_objects": len(scores), "n_stable": scores["stable"].eq(True).sum()}
    for name, metric in zip(["n_placed", *ORIENTED], METRICS, strict=False):
        found[name] = scores[metric].count()
    found |= {"n_shapes": scores["shape_iou"].count(), "n_articulated": scores["panels_correct"].count()}
    for name in COUNTS:
        found[name] = scores[name].sum()
    for name in AFFORDANCES:
        found[name] = scores[name].eq(True).sum()
    for metric in [*METRICS, "shape_iou"]:
        found[f"{metric}_mean"], found[f"{metric}_std"] = scores[metric].mean(), scores[metric].std()
    for metric, highest in (("l2_cm", np.inf), ("iou", 1.0)):
        low, high = np.clip(t_interval(scores[metric], confidence), 0.0, highest)  # no distance is negative
        found |= {f"{metric}_low": low, f"{metric}_high": high}
    return found


def first_rank(scores: pd.DataFrame) -> pd.DataFrame:
    """The rows of true objects in scenes of nearest cousins; measures are numbers, NaN where there is none."""
    found = scores[(scores["rank"] == 1) & (scores["true_asset"] != "")]
    return found.astype(dict.fromkeys(MEASURES, float))


def judge(scores: pd.DataFrame) -> str:
    """Who decided on models and orientations; with counts where several did, as where a judge abstained."""
    sides = [_count_deciders(scores[f"{what}_judge"]) for what in ("model", "orientation")]
    return sides[0] if sides[0] == sides[1] else f"{sides[0]}; orientation: {sides[1]}"


def _count_deciders(deciders: "pd.Series[str]") -> str:
    known = deciders[deciders != ""]
    counts = known.sort_values().value_counts()  # as many: by name
    if len(counts) < 2:
        return "".join(counts.index)
    return ", ".join(f"{name} {count}/{len(known)}" for name, count in counts.items())


def _published_total(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Published counts added up over `rows`, and means of L2 and IoU weighted by the objects of each scene.

    Orientation is left out: the paper does not say how many objects were symmetric. So are standard deviations.
    """
    rows = [row for row in rows if "published_n_objects" in row]
    if not rows:
        return {}
    objects = sum(row["published_n_objects"] for row in rows)
    total = {f"published_{name}": sum(row[f"published_{name}"] for row in rows) for name in ["n_objects", *COUNTS]}
    for name in ("published_l2_cm_mean", "published_iou_mean"):
        total[name] = sum(row[name] * row["published_n_objects"] for row in rows) / objects
    return total


def build(scores: pd.DataFrame, published: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """One row per (scene, variant) with `ALL_COLUMNS`, and a row `total` per variant that was run.

    Args:
        scores: rows of `SceneScore`; rank 1 (the nearest cousins) is used, rows of true objects only, without
            robustness variants.
        published: Table 2 of the paper, indexed by (scene number, variant).

    An object that was missed or that failed counts as not correct and has no distance, orientation or IoU. Standard
    deviations are sample ones. Cells of the configured grid without rows have the status `not run`. The total pools
    the objects of all scenes that were run; published totals are over the same scenes.
    """
    scores = first_rank(scores)
    scores = scores[scores["protocol"] == ""]
    scales = scores.groupby("scene")["scale_m"].first()
    scenes = [*options.scenes, *sorted(set(scores["scene"]) - set(options.scenes), key=sort_key)]
    variants = [*options.variants, *sorted(set(scores["variant"]) - set(options.variants))]
    variants.sort(key=lambda name: name != DEFAULT)
    groups = dict(list(scores.groupby(["scene", "variant"])))
    paper = dict(zip(published.index, records(published.add_prefix("published_")), strict=True))
    rows = []
    for scene in scenes:
        for variant in variants:
            group = groups.get((scene, variant))
            theirs = (options.scenes.get(scene), options.variants.get(variant))
            if group is None and None in theirs:
                continue
            row: dict[str, Any] = {"scene": scene, "variant": variant, "status": "not run"}
            if group is not None:
                row |= {"scale_m": scales[scene]} | _measure_scores(group, options.confidence)
            row |= paper.get(theirs, {})
            rows.append(row)
    for variant in variants:
        ran = [row for row in rows if row["variant"] == variant and row["status"] == "run"]
        if ran:
            pooled = _measure_scores(scores[scores["variant"] == variant], options.confidence)
            rows.append({"scene": TOTAL, "variant": variant} | pooled | _published_total(ran))
    table = pd.DataFrame(rows, columns=ALL_COLUMNS)
    counts = [*COUNTS, *AFFORDANCES]
    whole = [name for name in ALL_COLUMNS if name.startswith("n_") or name.removeprefix("published_") in counts]
    return table.astype(dict.fromkeys([*whole, "published_n_objects"], "Int64"))


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
