"""What people call the things of the rooms, and which names are sensible for each: kinds.yaml."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import yaml


@dataclass(frozen=True)
class ThingNames:
    """What people call such a thing, the categories of our library that are sensible cousins of it, its symmetry."""

    labels: list[str]
    sensible: list[str]
    turn: str


@cache
def stated_kinds() -> dict[str, ThingNames]:
    """The table of kinds.yaml."""
    rows = yaml.safe_load(Path(__file__).with_name("kinds.yaml").read_text(encoding="utf-8"))
    return {name: ThingNames(**fields) for name, fields in rows.items()}


def plain_name(name: str) -> str:
    """A name in small letters, words apart by one space, without a number at its end: `Office_Chair_2`."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])|[\W_]+", " ", name).casefold().split()
    return " ".join(words[:-1] if len(words) > 1 and words[-1].isdigit() else words)


def is_sensible(name: str, kind: str) -> bool:
    """Whether a thing of a kind may be called so: by its kind, a label of it, or a category that is its cousin."""
    known = stated_kinds()[kind]
    return plain_name(name) in {plain_name(word) for word in (kind, *known.labels, *known.sensible)}
