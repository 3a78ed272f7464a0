"""Families of near relatives: variations of a category's first models, the founders (docs/assets.md).

Of cabinets every other generation is near (the same fronts and kind of handle in other proportions, finishes, panels),
the others are farther: other fronts, handles and hinges. Relatives of all else are drawn anew in their founder's style.
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
CABINETS = {
    "bottom_cabinet": 24, "wall_cabinet": 9, "sideboard": 7, "wardrobe": 6, "chest_of_drawers": 8, "fridge": 4,
    "microwave": 4, "oven": 3, "dishwasher": 2,
}  # fmt: skip
FOUNDERS = CABINETS | {
    "table": 5, "coffee_table": 4, "chair": 6, "stool": 3, "sofa": 4, "bed": 3, "bookshelf": 5, "floor_lamp": 3,
    "table_lamp": 4, "television": 4, "picture": 4, "bowl": 5, "mug": 5, "plate": 3, "cooking_pot": 3, "bottle": 3,
    "vase": 4, "plant_pot": 4, "box": 4, "book": 3,
    "armchair": 4, "basket": 4, "bench": 4, "candlestick": 4, "clock": 4, "desk": 4, "jar": 4, "kettle": 4, "laptop": 3,
    "mirror": 3, "nightstand": 5, "pan": 3, "toaster": 3, "trash_can": 3, "tv_stand": 5, "wall_shelf": 5,
}  # fmt: skip
IN_TURN = 24  # models of a category that vary its founders in turn, at least
ABOUT = 2  # doors and drawers more or less, as matching's count_threshold (A.7)
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


def in_turn(category: str, index: int) -> bool:
    """Whether a relative varies the founder whose turn it is; later ones go where models with such fronts are few."""
    return category not in FRONTS or index < max(IN_TURN, 3 * FOUNDERS[category] // 2)


def fewest(fronts: list[tuple[int, int]], founders: int) -> int:
    """Which founder has the fewest models with about as many doors and drawers as it; `fronts`: those of all models."""
    alike = [sum(abs(a - c) + abs(b - d) <= ABOUT for c, d in fronts) for a, b in fronts[:founders]]
    return alike.index(min(alike))


def relative(category: str, founder: Draw, generation: int, rng: Rng, any_fronts: bool = True) -> Draw:
    """A variation of a founder of the `CABINETS`; odd generations are near, even ones farther from it: with any
    fronts of their category, or with one cell more or less than it."""
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
            fronts = FRONTS[category] if any_fronts else _resized(recipe)
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


def _resized(recipe: CabinetRecipe) -> list[Fronts]:
    """The recipe's fronts with one cell more or less in one of its lines."""
    found: list[Fronts] = []
    for k, line in enumerate(recipe.layout):
        for changed in ([*line, line[-1]], line[:-1] if len(line) > 1 else None):
            if changed is not None:
                lines = [*recipe.layout[:k], changed, *recipe.layout[k + 1 :]]
                found.append((recipe.major, [[str(cell) for cell in each] for each in lines]))
    return found


def _grid(major: str, layout: list[Any]) -> tuple[int, int]:
    """How many cells lie side by side, and how many one above the other."""
    longest = max(len(line) for line in layout)
    return (len(layout), longest) if major == "columns" else (longest, len(layout))


def _between(value: float, low: float, high: float) -> float:
    return round(float(min(max(value, low), high)), 3)
