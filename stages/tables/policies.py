"""Command `policies`: Table 3, Figures 4 and 9, from the rollouts of policies."""

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from roomkin.stages.config.evaluation import PolicyTables
from roomkin.stages.contracts.files import read_options
from roomkin.stages.tables import policy_tables, table3
from roomkin.stages.tables.figures import Panels, figure4, figure9, save, style
from roomkin.stages.tables.policy_tables import join_published, kinds_of, policy_notes, pool_rollouts, read_rollouts
from roomkin.stages.tables.rows import CELL, ROW, published_policies, published_runs
from roomkin.stages.tables.text import TextTable, write, write_csv

KNOWN = [*ROW, "cloud"]  # what is known of a row before it is rolled out
NOTHING_ASKED = pd.DataFrame(columns=[*CELL, "task", "cloud"])


class PolicyResults(NamedTuple):
    """Rollouts, pools in the place of their targets, and the frames of Table 3.

    published, published_runs: the paper's cells and runs, beside ours.
    """

    rollouts: pd.DataFrame
    runs: pd.DataFrame
    cells: pd.DataFrame
    differences: pd.DataFrame
    published: pd.DataFrame
    published_runs: pd.DataFrame


class More(NamedTuple):
    """What a package adds: frames by the names of their CSV files, and tables of them by those of their pages.

    Tables of `table3` stand below Table 3, `notes` below the tables of rollouts, `panels` before those of Figure 4.
    """

    frames: Mapping[str, pd.DataFrame] = {}
    tables: Mapping[str, list[TextTable]] = {}
    notes: list[str] = []
    panels: Panels | None = None


def collect(
    rollouts: pd.DataFrame, published: Path, options: PolicyTables, asked: pd.DataFrame = NOTHING_ASKED
) -> PolicyResults:
    """The frames of some rollouts (as `read_pooled` gives them); cells in `asked` without rollouts are `not run`."""
    ours = pd.concat([asked[KNOWN], rollouts[KNOWN]]).drop_duplicates()
    tables = published_policies(published), published_runs(published)
    paper, per_run = (join_published(table, ours, options) for table in tables)
    return PolicyResults(
        rollouts=rollouts,
        runs=table3.build(rollouts, pd.concat([asked, paper])[[*CELL, "task"]].drop_duplicates(), options),
        cells=table3.cells(rollouts, options), differences=table3.differences(rollouts, options), published=paper,
        published_runs=per_run,
    )  # fmt: skip


def write_figures(
    out: Path,
    found: PolicyResults,
    options: PolicyTables,
    panels: Panels | None = None,
    formats: tuple[str, ...] = ("svg", "png"),
) -> None:
    """Write figure4 and figure9."""
    with style():
        save(figure4(found.cells, found.published, panels, options.encoder), out, "figure4", formats)
        save(figure9(found.cells, found.published), out, "figure9", formats)


def run(
    *,
    out: Path,
    figures: Path | None = None,
    rollouts: tuple[Path, ...] = (),
    more: tuple[str, ...] = (),
    trainings: tuple[Path, ...] = (),
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write Table 3 (.csv, .html, .tex), table3_cells.csv, table3_differences.csv and Figures 4 and 9 (.svg, .png).

    Args:
        out: folder to write the tables into.
        figures: folder to write the figures into; that of the tables if left out.
        rollouts: rollouts.csv files of policies and of the skill.
        more: modules whose `add_tables` adds tables and panels, e.g. of the package claims (success over unseen assets,
            claims, stability of training).
        trainings: trainings.csv, for these: they name below the tables which trainings failed.
        published: folder with the paper's values, table3.csv.
        options: JSON of the config section `tables`, and of what policies are and which targets are pool_rollouts.
    """
    settings = read_options(PolicyTables, options)
    rows, kinds = read_rollouts(rollouts, settings), kinds_of(settings)
    found = collect(pool_rollouts(rows, settings), published, settings)
    added: list[More] = [import_module(name).add_tables(found, rows, trainings, settings) for name in more]
    notes = [*policy_notes(settings), *(note for each in added for note in each.notes)]
    tables = [policy_tables.policies_table(found.cells, found.published, settings, kinds, notes)]
    write(out, "table3", found.runs, [*tables, *(one for each in added for one in each.tables.get("table3", []))])
    write_csv(out / "table3_cells.csv", found.cells)
    write_csv(out / "table3_differences.csv", found.differences)
    for each in added:
        for name, frame in each.frames.items():
            if name in each.tables:
                write(out, name, frame, each.tables[name])
            else:
                write_csv(out / f"{name}.csv", frame)
    write_figures(figures or out, found, settings, next((each.panels for each in added if each.panels), None))
