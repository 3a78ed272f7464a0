"""Families of near relatives: variations of a category's first models, the founders (docs/assets.md).

Every other generation is near (the same fronts and kind of handle in other proportions, colours and panels), the others
are farther: other fronts, handles and hinges.
"""

import math
from typing import Any

import numpy as np

from stages.procedural.cabinet_draws import HANDLE_SHARES, HANDLES, PANELS
from stages.procedural.cabinet_recipe import CabinetRecipe
from stages.procedural.colours import APPLIANCE, METALS, PAINTS, WOODS, pick
from stages.procedural.finishes import shade
from stages.procedural.handles import PROTRUSION
from stages.procedural.model import Draw, Size

Rng = np.random.Generator
Fronts = tuple[str, list[list[str]]]  # columns or rows of cells, as in a cabinet's recipe

# The first models of a category are drawn freely, and rooms are furnished with them. Later ones are their variations.
FOUNDERS = {
    "bottom_cabinet": 24,
    "wall_cabinet": 9,
    "sideboard": 7,
    "wardrobe": 6,
    "chest_of_drawers": 8,
    "fridge": 4,
    "microwave": 4,
    "oven": 3,
    "dishwasher": 2,
}
APPLIANCES = {"fridge", "microwave", "oven", "dishwasher"}

D, P, O = ["door"], ["drawer"], ["open"]  # noqa: E741
FRONTS: dict[str, list[Fronts]] = {
    "bottom_cabinet": [
        ("columns", [D]),
        ("columns", [D, D]),
        ("columns", [D, D, D]),
        ("columns", [D, D, D, D]),
        ("columns", [[*P, *D]]),
        ("columns", [[*P, *D], [*P, *D]]),
        ("columns", [[*D, *P], [*D, *P]]),
        ("columns", [D, P * 3]),
        ("columns", [P * 4, D, D]),
        ("rows", [P, D * 2]),
        ("rows", [D * 2, P]),
    ],
    "wall_cabinet": [
        ("columns", [D]),
        ("columns", [D, D]),
        ("columns", [D, D, D]),
        ("columns", [D, D, D, D]),
        ("columns", [[*D, *O], [*D, *O]]),
        ("columns", [D, O]),
        ("rows", [D * 2, P * 2]),
    ],
    "sideboard": [
        ("columns", [D, P * 3, D]),
        ("columns", [D, P * 2, P * 2, D]),
        ("columns", [D, D, P * 3]),
        ("columns", [P * 3, D, D]),
        ("rows", [P * 3, D * 3]),
        ("columns", [D, O, D]),
        ("columns", [D, D, D, D]),
    ],
    "wardrobe": [
        ("columns", [D, D]),
        ("columns", [D, D, D]),
        ("columns", [D, D, D, D]),
        ("columns", [[*D, *P], [*D, *P]]),
        ("columns", [D, P * 5]),
        ("rows", [D * 2, P, P]),
    ],
    "chest_of_drawers": [
        ("columns", [P * 2]),
        ("columns", [P * 3]),
        ("columns", [P * 4]),
        ("columns", [P * 6]),
        ("columns", [P * 3, P * 3]),
        ("rows", [P * 2, P, P]),
        ("rows", [P * 3, P, P, P]),
        ("columns", [P * 4, D]),
    ],
}


def founder_of(category: str, index: int) -> int | None:
    """Number of the model that the `index`-th one of a category is a variation of; None: it is a founder itself."""
    founders = FOUNDERS.get(category)
    return None if founders is None or index < founders else index % founders


def relative(category: str, founder: Draw, generation: int, rng: Rng) -> Draw:
    """A variation of a founder; odd generations are near, even ones farther from it."""
    recipe, far = CabinetRecipe.model_validate(founder.parameters), generation % 2 == 0
    changes: dict[str, Any] = _looks(category, rng)
    # Wider and lower, or narrower and higher: a relative does not fit into its founder's box unchanged.
    spread = 0.22 if far else 0.14
    wider = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.0))
    factors = rng.uniform(-1.0, 1.0), wider, -wider * rng.uniform(0.5, 1.0)
    x, y, z = (extent * math.exp(spread * factor) for extent, factor in zip(founder.size, factors, strict=True))
    changes["handle_length"] = _between(recipe.handle_length * rng.uniform(0.7, 1.5), 0.1, 0.6)
    changes["handle_at"] = _between(recipe.handle_at + rng.uniform(-0.25, 0.25), -1.0, 1.0)
    changes["drawer_weight"] = _between(recipe.drawer_weight * rng.uniform(0.8, 1.3), 0.15, 0.6)
    if far:
        handle = str(rng.choice(HANDLES, p=HANDLE_SHARES))
        changes |= {"handle": handle, "protrusion": PROTRUSION[handle], "hinge": int(rng.choice([-1, 1]))}  # type: ignore[index]
        changes["handle_at"] = round(float(rng.uniform(-0.9, 0.9)), 3)
        if category in FRONTS and recipe.column_weights is None:
            fronts = FRONTS[category]
            major, layout = fronts[int(rng.integers(len(fronts)))]
            across, up = _grid(recipe.major, recipe.layout)
            new_across, new_up = _grid(major, layout)
            wider = new_across / across
            y *= math.sqrt(wider) if category in ("sideboard", "chest_of_drawers") else wider
            z *= math.sqrt(new_up / up) if category == "chest_of_drawers" else 1.0
            changes |= {"major": major, "layout": layout}
    elif rng.random() < 0.5:
        changes["inset_front"] = not recipe.inset_front and category not in APPLIANCES
    size: Size = (round(x, 3), round(y, 3), round(z, 3))
    return Draw(founder.generator, size, recipe.changed(**changes).parameters())


def _looks(category: str, rng: Rng) -> dict[str, Any]:
    """Colours, and where it is no appliance the style of the panels."""
    front = pick(rng, APPLIANCE) if category in APPLIANCES else pick(rng, PAINTS, WOODS)
    body = shade(front, 0.82) if rng.random() < 0.6 or category in APPLIANCES else pick(rng, PAINTS, WOODS)
    looks: dict[str, Any] = {"front_colour": front, "body_colour": body, "handle_colour": pick(rng, METALS)}
    if category in APPLIANCES:
        return looks | {"field_colour": front}
    panel = str(rng.choice(PANELS))
    return looks | {"field_colour": shade(front, float(rng.choice([0.72, 0.85, 1.2]))), "panel": panel}


def _grid(major: str, layout: list[Any]) -> tuple[int, int]:
    """How many cells lie side by side, and how many one above the other."""
    longest = max(len(line) for line in layout)
    return (len(layout), longest) if major == "columns" else (longest, len(layout))


def _between(value: float, low: float, high: float) -> float:
    return round(float(min(max(value, low), high)), 3)
