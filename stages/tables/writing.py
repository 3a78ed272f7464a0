"""A table as the files that the commands write."""

from pathlib import Path

import pandas as pd

from roomkin.stages.contracts.files import write_text
from roomkin.stages.tables.text import TextTable, html, latex


def write_csv(path: Path, table: pd.DataFrame) -> None:
    """A table as CSV, numbers with six digits."""
    write_text(path, table.to_csv(index=False, lineterminator="\n", float_format="%.6g"))


def write(out: Path, name: str, table: pd.DataFrame, tables: list[TextTable]) -> None:
    """`name`.csv, and the tables about it as .html and .tex."""
    write_csv(out / f"{name}.csv", table)
    write_text(out / f"{name}.html", html(tables, tables[0].caption))
    write_text(out / f"{name}.tex", latex(tables))
