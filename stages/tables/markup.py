"""A table as HTML and as LaTeX."""

import math
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import jinja2


@dataclass(frozen=True)
class Cell:
    """What one cell shows: our value, a remark on it (its interval, its n), the paper's value beside it."""

    value: str
    remark: str = ""
    published: str = ""


@dataclass(frozen=True)
class Row:
    """A line of a table; `kind` is '', 'not-run' or 'total'."""

    cells: list[Cell]
    kind: str = ""


@dataclass(frozen=True)
class Table:
    """A table to show; the first `headers` columns name the row."""

    name: str
    caption: str
    columns: list[str]
    rows: list[Row]
    headers: int = 1
    notes: list[str] = field(default_factory=list)

    @property
    def missing(self) -> list[Row]:
        """The rows that were not run."""
        return [row for row in self.rows if row.kind == "not-run"]

    def ran(self) -> "Table":
        """The rows that were run, and of the columns those in which one of them says something else than not run."""
        rows = [row for row in self.rows if row.kind != "not-run"]
        kept = [
            index
            for index in range(len(self.columns))
            if index < self.headers or any(row.cells[index].value not in ("", NOT_RUN) for row in rows)
        ]
        return replace(
            self,
            columns=[self.columns[index] for index in kept],
            rows=[replace(row, cells=[row.cells[index] for index in kept]) for row in rows],
        )


NOT_RUN = "not run"


def number(value: Any, digits: int) -> str:
    """A number with fixed digits; nothing for a missing one."""
    return "" if value is None or value != value or math.isinf(value) else f"{value:.{digits}f}"


def spread(mean: Any, std: Any, digits: int) -> str:
    """'mean ± std', without the part that is missing."""
    middle, width = number(mean, digits), number(std, digits)
    return f"{middle} ± {width}" if middle and width else middle


def percent(mean: Any, std: Any = None) -> str:
    """A rate in percent, '92 %' or '92 ± 4 %'; 0 and 100 are said of nothing else: 320 of 321 are '99.7 %'."""
    if mean is None or mean != mean:
        return ""
    digits = next((digits for digits in (0, 1) if _keeps_clear(100 * mean, digits)), None)
    if digits is None:
        return "> 99.9 %" if mean > 0.5 else "< 0.1 %"
    width = None if std is None or std != std else 100 * std
    return f"{spread(100 * mean, width, digits)} %"


def _keeps_clear(value: float, digits: int) -> bool:
    """Whether rounding a percentage neither makes 0 or 100 of it nor, if it is one of them, anything else."""
    return all((round(value, digits) == end) == (value == end) for end in (0, 100))


def span(low: float, high: float) -> str:
    """An interval of rates in percent, '48–74', its ends rounded outwards; signs where it reaches below zero."""
    ends = math.floor(100 * low + 1e-9), math.ceil(100 * high - 1e-9)
    return f"{ends[0]:+d} to {ends[1]:+d}".replace("-", "−") if low < 0 else f"{ends[0]}–{ends[1]}"


def points(difference: float) -> str:
    """A difference of rates in percentage points, '+13 points'."""
    return f"{100 * difference:+.0f} points".replace("-", "−").replace("+0 ", "0 ").replace("−0 ", "0 ")


LATEX = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "±": r"$\pm$"}
LATEX |= {"–": "--", "−": "$-$", "≤": r"$\leq$", "×": r"$\times$", "(": "(", "²": "$^2$"}
LATEX |= {sign: "\\" + sign for sign in "&%$#_{}"}


def latex_escape(text: str) -> str:
    """Text in which LaTeX sees no command."""
    return "".join(LATEX.get(sign, sign) for sign in str(text))


def markdown(table: Table) -> str:
    """A table in Markdown, in cells as in HTML: our value, the remark, the paper's value."""

    def text(cell: Cell) -> str:
        paper = f"*paper {cell.published}*" if cell.published else ""
        return "<br>".join(part for part in (cell.value, cell.remark, paper) if part).replace("|", "\\|")

    lines = [f"**{table.caption}**", "", f"| {' | '.join(table.columns)} |", "|---" * len(table.columns) + "|"]
    lines += [f"| {' | '.join(text(cell) for cell in row.cells)} |" for row in table.rows]
    return "\n".join([*lines, "", *(f"{note}\n" for note in table.notes)])


@cache
def environment() -> jinja2.Environment:
    """Templates beside this module; HTML is escaped, an undefined name is an error."""
    made = jinja2.Environment(
        loader=jinja2.PackageLoader("stages.tables", "."),
        autoescape=jinja2.select_autoescape(["html.jinja"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters["tex"] = latex_escape
    return made


def html(tables: list[Table], title: str) -> str:
    """A small page of its own with the tables (the workflow's report shows it as it is)."""
    return environment().get_template("table_page.html.jinja").render(tables=tables, title=title)


def latex(tables: list[Table]) -> str:
    r"""The tables as `table` environments; they need \usepackage{booktabs, xcolor}."""
    return environment().get_template("table.tex.jinja").render(tables=tables)
