"""A table as the files that the verbs write."""

from pathlib import Path

import pandas as pd

from stages.contracts.files import write_text
from stages.tables.markup import Table, html, latex


def as_csv(table: pd.DataFrame) -> str:
    """A table as text, numbers with six digits."""
    return table.to_csv(index=False, lineterminator="\n", float_format="%.6g")


def write(out: Path, name: str, table: pd.DataFrame, shown: list[Table]) -> None:
    """`name`.csv, and .html and .tex with all that is shown of it."""
    write_text(out / f"{name}.csv", as_csv(table))
    write_text(out / f"{name}.html", html(shown, shown[0].caption))
    write_text(out / f"{name}.tex", latex(shown))
