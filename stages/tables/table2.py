"""Table 2: how well the scenes of nearest cousins match the rooms they were made from (paper B.1)."""

from typing import Any

import numpy as np
import pandas as pd

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.tables.intervals import t_interval
from roomkin.stages.tables.rows import DEFAULT, records, sort_key

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
    cell: dict[str, Any] = {"status": "run", "judge": judge(scores)}
    cell |= {
        "n_scenes": scores["scene"].nunique(),
        "n_objects": len(scores),
        "n_stable": scores["stable"].eq(True).sum(),
    }
    for name, metric in zip(["n_placed", *ORIENTED], METRICS, strict=False):
        cell[name] = scores[metric].count()
    cell |= {"n_shapes": scores["shape_iou"].count(), "n_articulated": scores["panels_correct"].count()}
    for name in COUNTS:
        cell[name] = scores[name].sum()
    for name in AFFORDANCES:
        cell[name] = scores[name].eq(True).sum()
    for metric in [*METRICS, "shape_iou"]:
        cell[f"{metric}_mean"], cell[f"{metric}_std"] = scores[metric].mean(), scores[metric].std()
    for metric, highest in (("l2_cm", np.inf), ("iou", 1.0)):
        low, high = np.clip(t_interval(scores[metric], confidence), 0.0, highest)  # no distance is negative
        cell |= {f"{metric}_low": low, f"{metric}_high": high}
    return cell


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
    paper = {
        key: {f"published_{name}": value for name, value in cell.items()}
        for key, cell in zip(published.index, records(published), strict=True)
    }
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
