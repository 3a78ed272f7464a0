"""Command `quote`: write the figures that README and guides take from docs/results; a test says where they differ."""

import re
from collections.abc import Callable
from pathlib import Path

import yaml
from pydantic import BaseModel, ConfigDict, TypeAdapter

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import write_text

QUOTED = Path(__file__).with_name("quoted.yaml")
PLACE = re.compile(r"\{([^{}]+?)(?::([^{}:]+))?\}")  # {column} or {column:form}
NUMBER = r"[-+−]?\d+(?:\.\d+)?"


class Quote(BaseModel):
    """As quoted.yaml says."""

    model_config = ConfigDict(extra="forbid")

    page: Path
    source: Path
    row: str
    text: str


def _first(pattern: str) -> Callable[[str], str]:
    def find(cell: str) -> str:
        found = re.search(pattern, cell)
        if found is None:
            raise ValueError(f"'{cell}' has nothing like {pattern}")
        return found[0]

    return find


FORMS: dict[str | None, Callable[[str], str]] = {
    None: str,
    "%": lambda cell: re.sub(rf"^({NUMBER})", r"\1 %", cell),
    "of": lambda cell: _first(r"\d+/\d+")(cell).replace("/", " of "),
    "count": _first(NUMBER),
    "rate": _first(rf"{NUMBER} %"),
    "range": _first(r"\[[^]]*\]"),
}


def read_row(page: str, row: str) -> dict[str, str]:
    """Cells by column of the first row of a Markdown page that begins so.

    Raises:
        ValueError: there is none.
    """
    lines = page.splitlines()
    found = [number for number, line in enumerate(lines) if line.startswith(row)]
    if not found:
        raise ValueError(f"has no row that begins with '{row}'")
    head = next(number for number in range(found[0], 0, -1) if re.fullmatch(r"\|[ :|-]+", lines[number])) - 1
    names, cells = ([cell.strip() for cell in lines[at].strip().strip("|").split("|")] for at in (head, found[0]))
    return dict(zip(names, cells, strict=False))


def quote(page: str, text: str, cells: dict[str, str]) -> str:
    """The page with a text filled by cells in the place of the same text with other figures.

    Raises:
        ValueError: the page does not have it, a column lacks, or a cell has another form.
    """
    filled = PLACE.sub(lambda found: FORMS[found[2]](cells[found[1]]), text)
    parts = [re.escape(part) for part in PLACE.split(text)[::3]]
    found, count = re.subn(r"[^|\n]{1,40}?".join(parts), lambda _: filled, page)
    if count != 1:
        raise ValueError(f"has '{text}' {count} times")
    return found


def run(*, root: Path = Path()) -> None:
    """Write the figures.

    Args:
        root: of the repository.
    """
    for one in TypeAdapter(list[Quote]).validate_python(yaml.safe_load(QUOTED.read_text(encoding="utf-8"))):
        before = (root / one.page).read_text(encoding="utf-8")
        try:
            after = quote(before, one.text, read_row((root / one.source).read_text(encoding="utf-8"), one.row))
        except (ValueError, KeyError, StopIteration) as error:
            mend = "correct plugins/studies/quoted.yaml, or the page"
            raise InputError(f"{one.page} from {one.source}", f"{error}.", mend, code="E-QUOTE") from None
        if after != before:
            write_text(root / one.page, after)
            print(f"{one.page}: from {one.source}")
