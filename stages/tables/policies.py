"""Verb `policies`: success over unseen assets, Table 3, and what goes with them, from the rollouts of policies."""

from pathlib import Path
from typing import NamedTuple

import pandas as pd

from stages.config.tables import TablesConfig
from stages.contracts.files import read_options, write_text
from stages.contracts.policies import Rollout
from stages.tables import assets, claims, formatting, table3
from stages.tables.asset_tables import assets_table, by_handle_table
from stages.tables.claim_tables import claims_table, stability_table
from stages.tables.markup import Table
from stages.tables.rows import published_policies, published_runs, read_rows
from stages.tables.writing import as_csv, write

ONE_TEST = ["task", "training_set", "run", "seed", "checkpoint", "test_asset"]


class Found(NamedTuple):
    """All that is said of policies: the frames behind the tables."""

    assets: pd.DataFrame
    by_handle: pd.DataFrame
    runs: pd.DataFrame
    cells: pd.DataFrame
    differences: pd.DataFrame
    claims: pd.DataFrame
    stability: pd.DataFrame


def find(rollouts: pd.DataFrame, asked: pd.DataFrame, published: pd.DataFrame, options: TablesConfig) -> Found:
    """The frames of some rows of `Rollout`; cells that were `asked` for are said to be not run.

    Args:
        published: the paper's runs, as `published_runs` gives them.
    """
    runs = table3.build(rollouts, asked, options)
    return Found(
        assets=assets.build(rollouts, options),
        by_handle=assets.by_handle(rollouts, options),
        runs=runs,
        cells=table3.cells(rollouts, options),
        differences=table3.differences(rollouts, options),
        claims=claims.answer(rollouts, published, options),
        stability=claims.stability(runs, published),
    )


def asset_tables(found: Found, options: TablesConfig) -> list[Table]:
    """The tables over sets of unseen assets; none if there are no such rows."""
    if found.assets.empty:
        return []
    return [assets_table(found.assets, options), by_handle_table(found.by_handle, options)]


def role_tables(found: Found, paper: pd.DataFrame, options: TablesConfig) -> list[Table]:
    """Table 3 and what goes with it."""
    shown = [formatting.policies_table(found.cells, paper, options)]
    shown += [claims_table(found.claims, options)] if len(found.claims) else []
    shown += [stability_table(found.stability)] if len(found.stability) else []
    shown += [formatting.differences_table(found.differences, options)] if len(found.differences) else []
    return shown


def run(
    *,
    out: Path,
    rollouts: tuple[Path, ...] = (),
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write assets.{csv,html,tex}, assets_by_handle.csv, table3.{csv,html,tex}, table3_<what>.csv into `out`.

    What: cells, differences, claims, stability.

    Args:
        out: folder to write into.
        rollouts: rollouts.csv files of policies and of the skill.
        published: folder with the paper's values, table3.csv.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    episodes, paper = read_rows(Rollout, rollouts, ONE_TEST), published_policies(published)
    found = find(episodes, paper, published_runs(published), settings)
    write(out, "assets", found.assets, asset_tables(found, settings) or [assets_table(found.assets, settings)])
    write_text(out / "assets_by_handle.csv", as_csv(found.by_handle))
    shown = role_tables(found, paper, settings)
    shown += [formatting.runs_table(found.runs)] if (found.runs["status"] == "run").any() else []
    write(out, "table3", found.runs, shown)
    for what in ("cells", "differences", "claims", "stability"):
        write_text(out / f"table3_{what}.csv", as_csv(getattr(found, what)))
