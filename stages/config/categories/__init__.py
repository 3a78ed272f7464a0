"""Facts about the library's categories for the config, written by their maker: the workflow starts without it."""

import json
from pathlib import Path
from typing import NamedTuple

FILE = Path(__file__).with_name("categories.json")


class Known(NamedTuple):
    """Models of a category in the default library, perhaps none; whether the first of them have doors, and drawers."""

    models: int
    doors: bool
    drawers: bool


CATEGORIES = {name: Known(*values) for name, values in json.loads(FILE.read_text(encoding="utf-8")).items()}
