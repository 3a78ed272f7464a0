"""What the config knows of the library's categories; written by `python -m stages.config` from their records, so that
the workflow starts without importing the generators of models."""

import json
from pathlib import Path
from typing import NamedTuple

FILE = Path(__file__).with_name("categories.json")


class Known(NamedTuple):
    """Models of a category in the default library; whether the first of them have doors, and drawers."""

    models: int
    doors: bool
    drawers: bool


def generated() -> str:
    """The text of the file, from the records."""
    from stages.procedural.catalogue import CATEGORIES, opens

    lines = [f'"{name}": {json.dumps([record.count, *opens(name)])}' for name, record in CATEGORIES.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


CATEGORIES = {name: Known(*values) for name, values in json.loads(FILE.read_text(encoding="utf-8")).items()}
