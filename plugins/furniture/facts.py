"""Command `facts`: what others know of the categories here without making a model of one."""

import json

from roomkin.plugins.furniture.catalogue import ALL, CATEGORIES, has_fronts, leaves, sample
from roomkin.plugins.furniture.category import Category
from roomkin.plugins.furniture.real_sizes import REAL_SIZES
from roomkin.stages.config import categories as counts
from roomkin.stages.contracts import categories
from roomkin.stages.contracts.category import Category as Row
from roomkin.stages.contracts.files import write_text

SAMPLES = 8  # models of a category that say how large it usually is: more than have templates


def describe_category(record: Category) -> Row:
    """The row of a category."""
    doors, flaps = leaves(record.name)

    def sizes(numbers: range) -> list[list[float]]:
        return [list(sample(record.name, number, 0).parameters["size"]) for number in numbers]  # type: ignore[arg-type]

    return Row.model_validate(
        {
            "name": record.name,
            "names": _split(record.names),
            "like": _split(record.like),
            "kin": _split(record.kin),
            "places": _split(record.places),
            "carries": record.carries,
            "doors": doors,
            "flaps": flaps,
            "sizes": sizes(range(SAMPLES)),
            "further": sizes(record.further),
            "real": REAL_SIZES.get(record.name, ()),
        }
    )


def _split(words: str) -> list[str]:
    return [word.strip() for word in words.split(",") if word.strip()]


def categories_text() -> str:
    """The file of `roomkin.stages.contracts.categories`: a row per category of the default library."""
    rows = [describe_category(record).model_dump_json(exclude_defaults=True) for record in CATEGORIES.values()]
    return "[\n" + ",\n".join(rows) + "\n]\n"


def counts_text() -> str:
    """The file of `roomkin.stages.config.categories`: models in the default library, and what they open."""
    lines = [f'"{name}": {json.dumps([record.count, *has_fronts(name)])}' for name, record in ALL.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def run() -> None:
    """Write both."""
    write_text(counts.FILE, counts_text())
    write_text(categories.FILE, categories_text())
