"""Verb `figures`: Figures 4 and 9 as SVG and PNG."""

from pathlib import Path

import pandas as pd

from stages.config.tables import TablesConfig
from stages.contracts.files import read_options
from stages.contracts.policies import Rollout
from stages.tables import asset_panels, table3
from stages.tables.drawing import look, save
from stages.tables.policies import ONE_TEST
from stages.tables.policy_figures import figure4, figure9
from stages.tables.rows import published_policies, read_rows


def write_figures(out: Path, rollouts: pd.DataFrame, paper: pd.DataFrame, options: TablesConfig) -> None:
    """Write figure4 and figure9 (.svg, .png); `paper` as `published_policies` gives."""
    cells = table3.cells(rollouts, options)
    points = asset_panels.points(rollouts)
    with look():
        save(
            figure4(cells, paper, (points, asset_panels.thirds(rollouts, options)) if len(points) else None),
            out,
            "figure4",
        )
        save(figure9(cells, paper), out, "figure9")


def run(
    *,
    out: Path,
    rollouts: tuple[Path, ...] = (),
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write figure4 and figure9 (.svg and .png) into `out`; what was not run is drawn as such.

    Args:
        out: folder to write into.
        rollouts: rollouts.csv files of policies.
        published: folder with the paper's values.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    write_figures(out, read_rows(Rollout, rollouts, ONE_TEST), published_policies(published), settings)
