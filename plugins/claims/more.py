"""Additions to Table 3: success on unseen assets and upper panels of Figure 4, claims, stability of training."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from roomkin.plugins.claims import assets, claims, tables
from roomkin.plugins.claims.assets import find_judged_set, first_policies, of_splits
from roomkin.plugins.claims.trainings import failed_note, read_trainings
from roomkin.stages.config.evaluation import PolicyTables, TablesConfig
from roomkin.stages.tables.figures import Panels, Row, color, draw_rates, mark_not_run, marker, of_row, rate_axis
from roomkin.stages.tables.policies import More, PolicyResults
from roomkin.stages.tables.policy_tables import Kinds, kinds_of, policy_notes
from roomkin.stages.tables.rows import ROW, SKILL, rates, records, row_title, set_key
from roomkin.stages.tables.text import TextTable, distance_from_twin

AXES = ["feature_distance", "handle_length"]


def _select_judged(rollouts: pd.DataFrame) -> pd.DataFrame:
    """The rollouts of policies on the set of assets that their task is judged over."""
    policies = of_splits(rollouts[rollouts["training_set"] != SKILL])
    parts = [part[part["test_asset"] == find_judged_set(part)] for _, part in policies.groupby(ROW, sort=False)]
    return pd.concat(parts) if parts else policies


def spread_points(rollouts: pd.DataFrame) -> pd.DataFrame:
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


def draw_panels(panels: Any, spread_points: pd.DataFrame, thirds: pd.DataFrame, encoder: str) -> None:
    """The panels of one target and policy."""
    labels = [distance_from_twin(encoder), "length of the handle (m)"]
    for panel, axis, label in zip(panels, AXES, labels, strict=True):
        rate_axis(panel, False)
        panel.set_xlabel(f"{label}, {spread_points['asset'].nunique()} assets" if len(spread_points) else label)
        panel.grid(False, axis="x")
        if spread_points.empty:
            mark_not_run(panel)
            panel.set_xticks([])
            continue
        panel.set_title(row_title(records(spread_points)[0]), loc="left")
        _draw(panel, axis, spread_points, thirds[thirds["axis"] == axis])


def _draw(panel: Axes, axis: str, spread_points: pd.DataFrame, thirds: pd.DataFrame) -> None:
    """Faint points, an asset each; thirds with their intervals on a line. Different sets stand beside each other."""
    sets = sorted(spread_points["training_set"].unique(), key=set_key)
    step = 0.02 * (float(spread_points[axis].max() - spread_points[axis].min()) or 1.0)
    for index, name in enumerate(sets):
        shift = step * (index - (len(sets) - 1) / 2)
        mine = spread_points[spread_points["training_set"] == name]
        panel.scatter(
            mine[axis] + shift, 100 * mine["mean"], s=13, alpha=0.35, linewidths=0.6, color=color(name),
            marker=marker(name),
        )  # fmt: skip
        line = thirds[thirds["training_set"] == name].sort_values("place")
        draw_rates(panel, line["place"] + shift, line, name)


class MoreResults(NamedTuple):
    """The frames of some rollouts."""

    assets: pd.DataFrame
    by_handle: pd.DataFrame
    claims: pd.DataFrame
    stability: pd.DataFrame


def collect(found: PolicyResults, options: PolicyTables) -> MoreResults:
    """The frames beside those of Table 3."""
    rollouts = found.rollouts
    return MoreResults(
        assets=assets.build(rollouts, options, first_policies(rollouts, options)),
        by_handle=assets.by_handle(rollouts, options),
        claims=claims.answer(rollouts, found.published_runs, options),
        stability=claims.stability(found.runs, found.published_runs),
    )


def asset_tables(more: MoreResults, options: PolicyTables, kinds: Kinds, notes: list[str]) -> list[TextTable]:
    """The tables over sets of unseen assets; none if there are no such rows."""
    if more.assets.empty:
        return []
    return [tables.assets_table(more.assets, options, kinds, notes), tables.by_handle_table(more.by_handle, options)]


def target_tables(rollouts: pd.DataFrame, options: PolicyTables, kinds: Kinds) -> list[TextTable]:
    """The table over unseen assets for the targets of pools, each for itself; `rollouts` as `read_rollouts` has it."""
    alone = rollouts[rollouts["target"].isin([name for names in options.pools.values() for name in names])]
    built = assets.build(alone, options, first_policies(alone, options.model_copy(update={"pools": {}})))
    if built.empty:
        return []
    table = tables.assets_table(built, options, kinds)
    return [replace(table, name="assets_by_target", caption=f"{table.caption[:-1]}, target by target.")]


def claim_tables(more: MoreResults, options: PolicyTables) -> list[TextTable]:
    """The claims, the stability of training."""
    found = [tables.claims_table(more.claims, options)] if len(more.claims) else []
    return found + ([tables.stability_table(more.stability)] if len(more.stability) else [])


def make_panels(rollouts: pd.DataFrame, options: PolicyTables) -> Panels | None:
    """Success on every unseen asset against distance and against the length of the handle; None without such rows."""
    points = spread_points(rollouts)
    if points.empty:
        return None
    thirds = tabulate_thirds(rollouts, options)

    def draw(panels: Sequence[Axes], row: Row) -> None:
        draw_panels(panels, of_row(points, row), of_row(thirds, row), options.encoder)

    return Panels(len(AXES), points, draw)


def add_tables(found: PolicyResults, rows: pd.DataFrame, trainings: Sequence[Path], options: PolicyTables) -> More:
    """The tables that the command `policies` writes, too; `rows`: the rollouts before targets are pooled."""
    more, kinds = collect(found, options), kinds_of(options)
    failed = failed_note(read_trainings(next(iter(trainings), None)))
    unseen = asset_tables(more, options, kinds, [*policy_notes(options), *failed])
    unseen = unseen or [tables.assets_table(more.assets, options)]
    return More(
        frames={
            "assets": more.assets,
            "assets_by_handle": more.by_handle,
            "table3_claims": more.claims,
            "table3_stability": more.stability,
        },
        tables={"assets": [*unseen, *target_tables(rows, options, kinds)], "table3": claim_tables(more, options)},
        notes=failed,
        panels=make_panels(found.rollouts, options),
    )
