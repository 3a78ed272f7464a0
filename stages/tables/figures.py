"""Verb `figures`: Figures 4 and 9 as SVG and PNG."""

from pathlib import Path

import pandas as pd

from stages.config.tables import TablesConfig
from stages.contracts.files import read_options
from stages.tables.drawing import look, save
from stages.tables.policy_figures import figure4, figure9
from stages.tables.rows import published_policies, read_table
from stages.tables.table3 import ALL_COLUMNS, pool

TEXT = ["task", "cloud", "test_asset", "training_set", "run", "checkpoint", "asset", "status"]


def run(
    *,
    out: Path,
    table3_csv: Path | None = None,
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write figure4 and figure9 (.svg and .png) into `out`; what was not run is drawn as such.

    Args:
        out: folder to write into.
        table3_csv: table3.csv, as the verb `policies` wrote it.
        published: folder with the paper's values.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    paper = published_policies(published)
    rows = read_table(table3_csv, ALL_COLUMNS, TEXT) if table3_csv else pd.DataFrame(columns=ALL_COLUMNS)
    pooled = pool(rows, settings.confidence)
    with look():
        save(figure4(pooled, paper), out, "figure4")
        save(figure9(pooled, paper), out, "figure9")
