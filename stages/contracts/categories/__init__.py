"""The categories that everything here knows by name, from `categories.json`, which the maker of our library writes."""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.category import CategoryFacts, UsualSize, find_category
from roomkin.stages.contracts.errors import list_plain_words, plain_letters

FILE = Path(__file__).with_name("categories.json")
WORDS = Path(__file__).with_name("words.txt")  # of other languages
BEFORE = {  # what follows is another thing
    "aus", "avec", "con", "da", "das", "de", "del", "della", "di", "do", "en", "met", "mit", "of", "van", "von", "with",
}  # fmt: skip
SHORTEST_END = 5  # letters of a Latin word that ends another one (Bürostuhl); of other scripts, two


@cache
def known_categories() -> Mapping[str, CategoryFacts]:
    """By name, in order of name."""
    rows = [CategoryFacts.model_validate(row) for row in json.loads(FILE.read_text(encoding="utf-8"))]
    return {row.name: row for row in rows}


@cache
def foreign_words() -> Mapping[str, str]:
    """Names of categories by words of other languages, in plain letters and without spaces."""
    rows = (line.split(":") for line in WORDS.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    return {plain_letters(word).replace("_", ""): category for category, words in rows for word in words.split()}


def category_in(name: str) -> str | None:
    """The name of the known category that a name means, in English or in another language; None: none, or several."""
    if foreign := _find_foreign(name):
        return foreign
    found = find_category(name, known_categories())
    return found.name if found else None


def _find_foreign(name: str) -> str | None:
    """The category that a name means in another language than English, by its longest words; None: none, or several."""
    known, words = foreign_words(), list_plain_words(name)
    head = words[: next((place for place, word in enumerate(words) if place and word in BEFORE), len(words))]
    spans = ("".join(words[start:end]) for start in range(len(words)) for end in range(start + 2, len(words) + 1))
    ends = (word[start:] for word in head for start in range(1, len(word)))
    for group in (spans, head, (end for end in ends if len(end) >= (SHORTEST_END if end.isascii() else 2))):
        found = sorted((one for one in group if one in known), key=len)
        if found:
            return known[found[-1]] if len({known[one] for one in found if len(one) == len(found[-1])}) == 1 else None
    return None


def find_usual_size(category: str | None) -> UsualSize | None:
    """Of a category by its name; None: nobody knows."""
    known = known_categories().get(category or "")
    return known.measure_usual_size() if known else None


def sizes_of(label: str) -> NDArray[np.float64]:
    """Depth, width and height (N, 3), metres, of models of the category that a label means; (0, 3): none."""
    found = find_category(label, known_categories())
    return np.array(found.sizes if found else [], dtype=float).reshape(-1, 3)


def usual_depth(label: str) -> float | None:
    """How deep things of a label are; None: of no known one."""
    found = find_category(label, known_categories())
    return found.find_usual_depth() if found else None
