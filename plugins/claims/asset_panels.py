"""Upper panels of Figure 4: success on every unseen asset, against what it looks like."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from roomkin.plugins.claims.assets import find_judged_set, of_splits
from roomkin.stages.config.tables import TablesConfig
from roomkin.stages.tables.cells import ROW, rates
from roomkin.stages.tables.figures import color, draw_rates, mark_not_run, marker, rate_axis
from roomkin.stages.tables.order import SKILL, row_title, set_key
from roomkin.stages.tables.rows import records
from roomkin.stages.tables.text import distance_from_twin

AXES = ["feature_distance", "handle_length"]


def _select_judged(rollouts: pd.DataFrame) -> pd.DataFrame:
    """The rollouts of policies on the set of assets that their task is judged over."""
    policies = of_splits(rollouts[rollouts["training_set"] != SKILL])
    parts = [part[part["test_asset"] == find_judged_set(part)] for _, part in policies.groupby(ROW, sort=False)]
    return pd.concat(parts) if parts else policies


def points(rollouts: pd.DataFrame) -> pd.DataFrame:
    """A row per target, policy, training set and asset: mean success over runs and states, and `AXES`."""
    groups = _select_judged(rollouts).groupby([*ROW, "training_set", "asset"], sort=False)
    return groups.agg(mean=("success", "mean"), **{axis: (axis, "first") for axis in AXES}).reset_index()


def tabulate_thirds(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """A row per target, policy, training set, axis and third of assets along it: `place` (median), and as `rates`."""
    found, rows = _select_judged(rollouts), []
    for axis in AXES:
        for _, part in found.groupby(ROW, sort=False):
            places = part.drop_duplicates("asset").set_index("asset")[axis]
            third = (places.rank() * 3 / len(places)).apply(np.ceil)  # alike assets are in one third
            median = places.groupby(third.to_numpy()).transform("median")
            part = part.assign(axis=axis, place=part["asset"].map(median))
            rows.append(rates(part, ["target", "policy", "training_set", "axis", "place"], options))
    return pd.concat(rows) if rows else pd.DataFrame(columns=ROW)


def draw(panels: Any, points: pd.DataFrame, thirds: pd.DataFrame, encoder: str) -> None:
    """The panels of one target and policy."""
    labels = [distance_from_twin(encoder), "length of the handle (m)"]
    for panel, axis, label in zip(panels, AXES, labels, strict=True):
        rate_axis(panel, False)
        panel.set_xlabel(f"{label}, {points['asset'].nunique()} assets" if len(points) else label)
        panel.grid(False, axis="x")
        if points.empty:
            mark_not_run(panel)
            panel.set_xticks([])
            continue
        panel.set_title(row_title(records(points)[0]), loc="left")
        _draw(panel, axis, points, thirds[thirds["axis"] == axis])


def _draw(panel: Axes, axis: str, points: pd.DataFrame, thirds: pd.DataFrame) -> None:
    """Faint points, an asset each; thirds with their intervals on a line. Different sets stand beside each other."""
    sets = sorted(points["training_set"].unique(), key=set_key)
    step = 0.02 * (float(points[axis].max() - points[axis].min()) or 1.0)
    for index, name in enumerate(sets):
        shift = step * (index - (len(sets) - 1) / 2)
        mine = points[points["training_set"] == name]
        panel.scatter(
            mine[axis] + shift, 100 * mine["mean"], s=13, alpha=0.35, linewidths=0.6, color=color(name),
            marker=marker(name),
        )  # fmt: skip
        line = thirds[thirds["training_set"] == name].sort_values("place")
        draw_rates(panel, line["place"] + shift, line, name)
