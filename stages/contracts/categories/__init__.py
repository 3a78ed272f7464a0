"""The categories that everything here knows by name, from `categories.json`, which the maker of our library writes."""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stages.contracts.category import Category, UsualSize, find_category

FILE = Path(__file__).with_name("categories.json")


@cache
def known_categories() -> Mapping[str, Category]:
    """By name, in order of name."""
    rows = [Category.model_validate(row) for row in json.loads(FILE.read_text(encoding="utf-8"))]
    return {row.name: row for row in rows}


def category_in(name: str) -> str | None:
    """The name of the known category that a name means; None: none."""
    found = find_category(name, known_categories())
    return found.name if found else None


def find_usual_size(category: str | None) -> UsualSize | None:
    """Of a category by its name; None: nobody knows."""
    known = known_categories().get(category or "")
    return known.measure_usual_size() if known else None


def sizes_of(label: str) -> NDArray[np.float64]:
    """Depth, width and height (N, 3), metres, of models of the category that a label means; (0, 3): none."""
    found = find_category(label, known_categories())
    return np.array(found.sizes if found else [], dtype=float).reshape(-1, 3)
