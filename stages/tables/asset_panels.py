"""Upper panels of Figure 4: success on every unseen asset, against what it looks like."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from stages.config.tables import TablesConfig
from stages.tables.assets import judged_over, of_splits
from stages.tables.cells import rates
from stages.tables.drawing import MARKERS, colour, legend_name, not_run, rate_axis
from stages.tables.order import SKILL, set_key, title

THIRDS = 3


class Axis(NamedTuple):
    """What stands along a panel."""

    column: str
    label: str
    factor: float = 1.0


AXES = (
    Axis("dino_distance", "distance from the twin"),
    Axis("handle_length", "length of the handle (cm)", 100.0),
)


def _judged(rollouts: pd.DataFrame) -> pd.DataFrame:
    """The rollouts of policies on the set of assets that their task is judged over."""
    policies = of_splits(rollouts[rollouts["training_set"] != SKILL])
    parts = [part[part["test_asset"] == judged_over(part)] for _, part in policies.groupby("task")]
    return pd.concat(parts) if parts else policies


def points(rollouts: pd.DataFrame) -> pd.DataFrame:
    """A row per task, training set and asset: mean success over runs and states, and the columns of `AXES`."""
    groups = _judged(rollouts).groupby(["task", "training_set", "asset"])
    return groups.agg(mean=("success", "mean"), **{axis.column: (axis.column, "first") for axis in AXES}).reset_index()


def thirds(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """A row per task, training set, axis and third of the assets along it: `place` (median), and as `rates`."""
    found, rows = _judged(rollouts), []
    for axis in AXES:
        for _, part in found.groupby("task"):
            places = part.drop_duplicates("asset").set_index("asset")[axis.column]
            third = (places.rank() * THIRDS / len(places)).apply(np.ceil)  # alike assets are in one third
            median = places.groupby(third.to_numpy()).transform("median")
            part = part.assign(axis=axis.column, place=part["asset"].map(median))
            rows.append(rates(part, ["task", "training_set", "axis", "place"], options))
    return pd.concat(rows) if rows else pd.DataFrame(columns=["task"])


def draw(panels: Any, points: pd.DataFrame, thirds: pd.DataFrame, first: bool) -> None:
    """The panels of one task; `first`: in the first column, which has the axis' name."""
    for panel, axis in zip(panels, AXES, strict=True):
        rate_axis(panel, first)
        panel.set_xlabel(f"{axis.label}, {points['asset'].nunique()} assets" if len(points) else axis.label)
        panel.grid(False, axis="x")
        if points.empty:
            not_run(panel)
            panel.set_xticks([])
            continue
        panel.set_title(title(points["task"].iloc[0]), loc="left")
        _draw(panel, axis, points, thirds[thirds["axis"] == axis.column])


def _draw(panel: Axes, axis: Axis, points: pd.DataFrame, thirds: pd.DataFrame) -> None:
    """Faint points, an asset each, those of different sets side by side; thirds with their intervals on a line."""
    sets = sorted(points["training_set"].unique(), key=set_key)
    along = axis.factor * points[axis.column]
    extent = float(along.max() - along.min()) or 1.0
    for index, name in enumerate(sets):
        offset = index - (len(sets) - 1) / 2
        mine = points["training_set"] == name
        look: dict[str, Any] = {"color": colour(name), "marker": MARKERS.get(name, "x")}
        panel.scatter(
            along[mine] + 0.012 * extent * offset, 100 * points["mean"][mine] + 1.2 * offset, s=13, alpha=0.35,
            linewidths=0.6, **look,
        )  # fmt: skip
        line = thirds[thirds["training_set"] == name].sort_values("place")
        bars = 100 * np.clip([line["mean"] - line["low"], line["high"] - line["mean"]], 0, None)
        panel.errorbar(
            axis.factor * line["place"] + 0.02 * extent * offset, 100 * line["mean"], yerr=bars, markersize=5,
            linewidth=1.8, elinewidth=1, capsize=2.5, label=legend_name(name), **look,
        )  # fmt: skip
