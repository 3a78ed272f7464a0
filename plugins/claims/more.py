"""Additions to Table 3: success over unseen assets, claims, stability of training, panels of Figure 4."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from matplotlib.axes import Axes

from roomkin.plugins.claims import asset_panels, assets, claims, tables
from roomkin.plugins.claims.assets import first_policies
from roomkin.plugins.claims.trainings import failed_note, read_trainings
from roomkin.stages.config.tables import PolicyTables
from roomkin.stages.tables.figures import Panels, Row, of_row
from roomkin.stages.tables.markup import Table
from roomkin.stages.tables.methods import Kinds, kinds_of
from roomkin.stages.tables.policies import More, PolicyResults
from roomkin.stages.tables.policy_tables import policy_notes


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


def asset_tables(more: MoreResults, options: PolicyTables, kinds: Kinds, notes: list[str]) -> list[Table]:
    """The tables over sets of unseen assets; none if there are no such rows."""
    if more.assets.empty:
        return []
    return [tables.assets_table(more.assets, options, kinds, notes), tables.by_handle_table(more.by_handle, options)]


def target_tables(rollouts: pd.DataFrame, options: PolicyTables, kinds: Kinds) -> list[Table]:
    """The table over unseen assets for the targets of pools, each for itself; `rollouts` as `read_rollouts` has it."""
    alone = rollouts[rollouts["target"].isin([name for names in options.pools.values() for name in names])]
    built = assets.build(alone, options, first_policies(alone, options.model_copy(update={"pools": {}})))
    if built.empty:
        return []
    table = tables.assets_table(built, options, kinds)
    return [replace(table, name="assets_by_target", caption=f"{table.caption[:-1]}, target by target.")]


def claim_tables(more: MoreResults, options: PolicyTables) -> list[Table]:
    """The claims, the stability of training."""
    found = [tables.claims_table(more.claims, options)] if len(more.claims) else []
    return found + ([tables.stability_table(more.stability)] if len(more.stability) else [])


def make_panels(rollouts: pd.DataFrame, options: PolicyTables) -> Panels | None:
    """Success on every unseen asset against distance and against the length of the handle; None without such rows."""
    points = asset_panels.points(rollouts)
    if points.empty:
        return None
    thirds = asset_panels.tabulate_thirds(rollouts, options)

    def draw(panels: Sequence[Axes], row: Row) -> None:
        asset_panels.draw(panels, of_row(points, row), of_row(thirds, row), options.encoder)

    return Panels(len(asset_panels.AXES), points, draw)


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
