"""Numbers and names as text; tables and notes in Markdown and HTML, and as the files that the commands write."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import compress, groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd

from roomkin.stages.contracts.files import write_text

NOT_RUN = "not run"
NOTHING = "–"


def number(value: Any, digits: int) -> str:
    """A number with fixed digits; empty for a missing one."""
    return "" if value is None or value != value or math.isinf(value) else f"{value:.{digits}f}"


def spread(mean: Any, std: Any, digits: int) -> str:
    """'mean ± std', without the part that is missing."""
    middle, width = number(mean, digits), number(std, digits)
    return f"{middle} ± {width}" if middle and width else middle


def percent(mean: Any, std: Any = None) -> str:
    """A rate in percent, '92 %' or '92 ± 4 %'. Only exact rates read 0 or 100: 320 of 321 is '99.7 %'."""
    if mean is None or mean != mean:
        return ""
    value = 100 * mean
    exact = value in (0, 100)
    digits = next((digits for digits in (0, 1) if exact or round(value, digits) not in (0, 100)), None)
    if digits is None:
        return "> 99.9 %" if mean > 0.5 else "< 0.1 %"
    return f"{spread(value, None if std is None else 100 * std, digits)} %"


def span(low: float, high: float) -> str:
    """An interval of rates in percent, '48–74', rounded outwards; with signs if it reaches below zero."""
    ends = math.floor(round(100 * low, 9)), math.ceil(round(100 * high, 9))
    return f"{ends[0]:+d} to {ends[1]:+d}".replace("-", "−") if low < 0 else f"{ends[0]}–{ends[1]}"


def interval(row: Mapping[str, Any], prefix: str = "") -> str:
    """That of a row, its ends in the columns `<prefix>low` and `<prefix>high`."""
    return f"[{span(row[f'{prefix}low'], row[f'{prefix}high'])}]"


def points(difference: float) -> str:
    """A difference of rates in percentage points, '+13 points'."""
    return f"{100 * difference:+.0f} points".replace("-", "−").replace("+0 ", "0 ").replace("−0 ", "0 ")


def distance_from_twin(encoder: str) -> str:
    """'distance from the twin (hog features)'; without an encoder, as it is known."""
    return "distance from the twin" + f" ({encoder} features)" * bool(encoder)


def cell(value: str, remark: str = "", published: str = "") -> str:
    """A table cell, a line each: our value, a remark (its interval, its n), the paper's value."""
    return "\n".join(part for part in (value, remark, published and f"paper {published}") if part)


@dataclass(frozen=True)
class TextTable:
    """A table of text (cells as `text.cell` writes them); the first `headers` columns name the row."""

    name: str
    caption: str
    columns: list[str]
    rows: list[list[str]]
    headers: int = 1
    notes: list[str] = field(default_factory=list)

    @property
    def groups(self) -> list[tuple[str, list[list[str]]]]:
        """Rows that follow each other with the same first cell, under it and without it; if none do, all under ""."""
        found = [(head, list(rows)) for head, rows in groupby(self.rows, key=itemgetter(0))]
        if self.headers < 2 or len(found) == len(self.rows):
            return [("", self.rows)]
        return [(head, [row[1:] for row in rows]) for head, rows in found]

    def drop_empty(self) -> "TextTable":
        """The rows that were run, and the columns with a value of ours."""
        rows = [row for row in self.rows if any(map(_is_ours, row[self.headers :])) or not any(map(_is_missing, row))]
        columns = [k < self.headers or any(_is_ours(row[k]) for row in rows) for k in range(len(self.columns))]
        kept = [list(compress(row, columns)) for row in rows]
        return replace(self, columns=list(compress(self.columns, columns)), rows=kept)


def _is_missing(cell: str) -> bool:
    return cell.split("\n")[0] == NOT_RUN


def _is_ours(cell: str) -> bool:
    """Whether a cell holds more than `not run` and the paper's value."""
    return cell != "" and not _is_missing(cell) and not cell.startswith("paper ")


def markdown(table: TextTable) -> str:
    """A table in Markdown, the paper's values in italics."""

    def text(cell: str) -> str:
        return re.sub(r"^(paper .*)$", r"*\1*", cell, flags=re.MULTILINE).replace("\n", "<br>").replace("|", "\\|")

    lines = [f"**{table.caption}**", "", f"| {' | '.join(table.columns)} |", "|---" * len(table.columns) + "|"]
    lines += [f"| {' | '.join(map(text, row))} |" for row in table.rows]
    return "\n".join([*lines, "", *(f"{note}\n" for note in table.notes)])


@cache
def environment(package: str = "roomkin.stages.tables") -> jinja2.Environment:
    """Templates of a package, then those beside this module; HTML is escaped, an undefined name is an error."""
    return jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(name, ".") for name in (package, "roomkin.stages.tables")]),
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True,
    )  # fmt: skip


def read_notes(name: str, package: str = "roomkin.stages.tables", **values: Any) -> list[str]:
    """The paragraphs that a macro of the package's notes.jinja gives, a line each."""
    notes = environment(package).overlay(autoescape=False).get_template("notes.jinja").module
    return [" ".join(part.split()) for part in getattr(notes, name)(**values).split("\n\n") if part.strip()]


def html(tables: list[TextTable], title: str) -> str:
    """A page with the tables alone."""
    return environment().get_template("table_page.html.jinja").render(tables=tables, title=title)


def latex(tables: list[TextTable]) -> str:
    r"""The tables as `table` environments, their notes as comments; they need \usepackage{booktabs}."""
    parts = ["% needs \\usepackage{booktabs}\n"]
    for table in tables:
        rows = [[cell.replace("\n", " ").replace("−", "-") for cell in row] for row in table.rows]
        style = pd.DataFrame(rows, columns=table.columns).style.hide(axis="index")
        style = style.format(escape="latex").format_index(axis=1, escape="latex")
        parts.append(
            style.to_latex(
                column_format="l" * table.headers + "r" * (len(table.columns) - table.headers),
                position_float="centering",
                hrules=True,
                caption=table.caption,
                label=f"tab:{table.name}",
            )
        )
        parts += [f"% {note}\n" for note in table.notes]
    return "\n".join(parts)


def write_csv(path: Path, table: pd.DataFrame) -> None:
    """A table as CSV, numbers with six digits."""
    write_text(path, table.to_csv(index=False, lineterminator="\n", float_format="%.6g"))


def write(out: Path, name: str, table: pd.DataFrame, tables: list[TextTable]) -> None:
    """`name`.csv, and the tables about it as .html and .tex."""
    write_csv(out / f"{name}.csv", table)
    write_text(out / f"{name}.html", html(tables, tables[0].caption))
    write_text(out / f"{name}.tex", latex(tables))
