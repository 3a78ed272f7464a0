"""Command `facts`: what others know of the categories without making a model; how large real things are beyond ours."""

import json
from collections.abc import Mapping

from roomkin.plugins.furniture.catalogue import ALL, CATEGORIES, has_fronts, leaves, sample
from roomkin.plugins.furniture.category import Category
from roomkin.stages.config import categories as counts
from roomkin.stages.contracts import categories
from roomkin.stages.contracts.category import CategoryFacts
from roomkin.stages.contracts.files import write_text

# Depth, width and height, metres, of things between which the others lie.
REAL_SIZES: Mapping[str, tuple[tuple[float, float, float], ...]] = {
    # IKEA METOD, 37 cm deep; EN 1116: worktops are 60 to 65 cm deep, 85 or 90 high; stock is 12 to 48 inches wide.
    "bottom_cabinet": ((0.37, 0.40, 0.72), (0.60, 0.30, 0.72), (0.65, 1.22, 0.92)),
    # Units in stock: 12 to 15 inches deep, 12 to 36 wide, 15 to 42 high.
    "wall_cabinet": ((0.30, 0.30, 0.38), (0.38, 0.91, 1.07)),
    # YCB objects (Calli et al., 2015): the boxes of gelatin and of crackers; ISO 3394: packages of 60 by 40 cm.
    "box": ((0.028, 0.085, 0.073), (0.06, 0.16, 0.21), (0.40, 0.60, 0.40)),
    # 24 to 75 inches at 16:9, on a wall and on a foot.
    "television": ((0.05, 0.53, 0.30), (0.35, 1.66, 1.00)),
    # 60 cm of the edge for each of 2 to 8 people, and a head at either end (Neufert).
    "table": ((0.70, 0.70, 0.72), (1.05, 2.40, 0.78)),
    # IKEA MALM; PAX; BILLY and KALLAX.
    "chest_of_drawers": ((0.48, 0.40, 0.55), (0.48, 0.40, 1.23), (0.48, 1.60, 0.78)),
    "wardrobe": ((0.35, 0.50, 2.01), (0.58, 3.00, 2.36)),
    # EN 442: 61 to 155 mm deep, 300 to 900 high; of towels up to 1.8 m.
    "radiator": ((0.061, 0.40, 0.30), (0.155, 3.00, 0.90), (0.10, 0.60, 1.80)),
    # Slim ones; those of North America.
    "washing_machine": ((0.33, 0.60, 0.82), (0.81, 0.69, 0.99)),
    # EN 31 and 33: basins that hang and stand on pedestals; tanks up to a sill.
    "sink": ((0.25, 0.36, 0.10), (0.56, 1.20, 1.00)),
    "toilet": ((0.48, 0.34, 0.34), (0.80, 0.45, 1.00)),
    "bookshelf": ((0.28, 0.40, 1.06), (0.39, 1.82, 2.37)),
}


SAMPLES = 8  # models of a category that say how large it usually is: more than have templates


def describe_category(record: Category) -> CategoryFacts:
    """The row of a category."""
    doors, flaps = leaves(record.name)

    def sizes(numbers: range) -> list[list[float]]:
        return [list(sample(record.name, number, 0).parameters["size"]) for number in numbers]  # type: ignore[arg-type]

    return CategoryFacts.model_validate(
        {
            "name": record.name, "names": _split(record.names), "like": _split(record.like), "kin": _split(record.kin),
            "places": _split(record.places), "carries": record.carries, "doors": doors, "flaps": flaps,
            "sizes": sizes(range(SAMPLES)), "further": sizes(record.further), "real": REAL_SIZES.get(record.name, ()),
        }
    )  # fmt: skip


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
