"""Verb `policies`: success over unseen assets, Table 3, Figures 4 and 9, from the rollouts of policies."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from stages.config.tables import PolicyTables
from stages.contracts.files import read_options
from stages.tables import asset_panels, assets, claims, policy_tables, table3
from stages.tables.cells import CELL, ROW
from stages.tables.drawing import save, style
from stages.tables.markup import Table
from stages.tables.methods import Kinds, first_policies, join_published, kinds_of, read_rollouts
from stages.tables.policy_figures import figure4, figure9
from stages.tables.policy_notes import policy_notes
from stages.tables.pooling import pool_rollouts
from stages.tables.rows import published_policies, published_runs
from stages.tables.trainings import failed_note, read_trainings
from stages.tables.writing import write, write_csv

KNOWN = [*ROW, "cloud"]  # what is known of a row before it is rolled out
NOTHING_ASKED = pd.DataFrame(columns=[*CELL, "task", "cloud"])


class PolicyResults(NamedTuple):
    """The frames behind the tables of policies; `published`: the paper's cells, beside ours."""

    assets: pd.DataFrame
    by_handle: pd.DataFrame
    runs: pd.DataFrame
    cells: pd.DataFrame
    differences: pd.DataFrame
    claims: pd.DataFrame
    stability: pd.DataFrame
    published: pd.DataFrame


def collect(
    rollouts: pd.DataFrame, published: Path, options: PolicyTables, asked: pd.DataFrame = NOTHING_ASKED
) -> PolicyResults:
    """The frames of some rollouts (as `read_pooled` gives them); cells in `asked` without rollouts are `not run`."""
    ours = pd.concat([asked[KNOWN], rollouts[KNOWN]]).drop_duplicates()
    paper, per_run = (
        join_published(table, ours, options) for table in (published_policies(published), published_runs(published))
    )
    runs = table3.build(rollouts, pd.concat([asked, paper])[[*CELL, "task"]].drop_duplicates(), options)
    return PolicyResults(
        assets=assets.build(rollouts, options, first_policies(rollouts, options)),
        by_handle=assets.by_handle(rollouts, options),
        runs=runs,
        cells=table3.cells(rollouts, options),
        differences=table3.differences(rollouts, options),
        claims=claims.answer(rollouts, per_run, options),
        stability=claims.stability(runs, per_run),
        published=paper,
    )


def asset_tables(found: PolicyResults, options: PolicyTables, kinds: Kinds, notes: list[str]) -> list[Table]:
    """The tables over sets of unseen assets; none if there are no such rows."""
    if found.assets.empty:
        return []
    return [
        policy_tables.assets_table(found.assets, options, kinds, notes),
        policy_tables.by_handle_table(found.by_handle, options),
    ]


def target_tables(rollouts: pd.DataFrame, options: PolicyTables, kinds: Kinds) -> list[Table]:
    """The table over unseen assets for the targets of pools, each for itself; `rollouts` as `read_rollouts` has it."""
    alone = rollouts[rollouts["target"].isin([name for names in options.pools.values() for name in names])]
    built = assets.build(alone, options, first_policies(alone, options.model_copy(update={"pools": {}})))
    if built.empty:
        return []
    table = policy_tables.assets_table(built, options, kinds)
    return [replace(table, name="assets_by_target", caption=f"{table.caption[:-1]}, target by target.")]


def role_tables(found: PolicyResults, options: PolicyTables, kinds: Kinds, notes: list[str]) -> list[Table]:
    """Table 3, the claims, the stability of training."""
    tables = [policy_tables.policies_table(found.cells, found.published, options, kinds, notes)]
    tables += [policy_tables.claims_table(found.claims, options)] if len(found.claims) else []
    return tables + ([policy_tables.stability_table(found.stability)] if len(found.stability) else [])


def write_figures(out: Path, rollouts: pd.DataFrame, found: PolicyResults, options: PolicyTables) -> None:
    """Write figure4 and figure9 (.svg, .png)."""
    points = asset_panels.points(rollouts)
    over_assets = (points, asset_panels.tabulate_thirds(rollouts, options)) if len(points) else None
    with style():
        save(figure4(found.cells, found.published, over_assets, options.encoder), out, "figure4")
        save(figure9(found.cells, found.published), out, "figure9")


def run(
    *,
    out: Path,
    figures: Path | None = None,
    rollouts: tuple[Path, ...] = (),
    trainings: Path | None = None,
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write success over unseen assets, Table 3 (each .csv, .html, .tex) and Figures 4 and 9 (.svg, .png).

    Also assets_by_handle.csv and table3_<what>.csv: cells, differences, claims, stability.

    Args:
        out: folder to write the tables into.
        figures: folder to write the figures into; that of the tables if left out.
        rollouts: rollouts.csv files of policies and of the skill.
        trainings: trainings.csv, to name below the tables which trainings failed.
        published: folder with the paper's values, table3.csv.
        options: JSON of the config section `tables`, and of what policies are and which targets are pooled.
    """
    settings = read_options(PolicyTables, options)
    rows, kinds = read_rollouts(rollouts, settings), kinds_of(settings)
    episodes = pool_rollouts(rows, settings)
    found = collect(episodes, published, settings)
    notes = [*policy_notes(settings), *failed_note(read_trainings(trainings))]
    tables = asset_tables(found, settings, kinds, notes) or [policy_tables.assets_table(found.assets, settings)]
    write(out, "assets", found.assets, [*tables, *target_tables(rows, settings, kinds)])
    write(out, "table3", found.runs, role_tables(found, settings, kinds, notes))
    write_csv(out / "assets_by_handle.csv", found.by_handle)
    for what in ("cells", "differences", "claims", "stability"):
        write_csv(out / f"table3_{what}.csv", getattr(found, what))
    write_figures(figures or out, episodes, found, settings)
