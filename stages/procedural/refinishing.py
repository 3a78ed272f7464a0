"""The same model in another finish: other colours, the same geometry (protocol `recoloured`)."""

from typing import Any

import numpy as np

from stages.contracts.library import Recipe
from stages.procedural.cabinet_draws import APPLIANCE
from stages.procedural.colours import CARDBOARD, FABRICS, GLAZES, GREENS, METALS, PAINTS, WOODS, Palette
from stages.procedural.lamps import SHADES

FIXED = {"screen_colour", "panel_colour", "inside_colour"}  # the same on every model
FAMILIES: list[Palette] = [WOODS + PAINTS, METALS, APPLIANCE, FABRICS, GLAZES, GREENS, CARDBOARD, SHADES]
OTHER = 0.12  # distance from the old colour from which a colour is another one
SHADED = 0.01  # a colour that is a multiple of another, to this relative accuracy, stays its shade

Colour = tuple[float, ...]


def refinished(recipe: Recipe, rng: np.random.Generator) -> Recipe:
    """The recipe with another colour for every part, from the palette that the old one is nearest to.

    What was of one colour stays of one colour, a shade stays a shade of the other's new colour.
    """
    new: dict[Colour, Colour] = {}

    def repaint(value: list[float]) -> list[float]:
        old = tuple(value)
        if old not in new:
            new[old] = _shade_of(old, new) or _another(old, rng)
        return list(new[old])

    parameters: dict[str, Any] = dict(recipe.parameters)
    for key, value in parameters.items():
        if is_colour(key):
            parameters[key] = [channel for k in range(0, len(value), 3) for channel in repaint(value[k : k + 3])]
    return recipe.model_copy(update={"parameters": parameters})


def is_colour(key: str) -> bool:
    """Whether a parameter of a recipe is a colour (or several) that may be another one."""
    return key not in FIXED and (key in ("colours", "inside") or "colour" in key)


def _another(old: Colour, rng: np.random.Generator) -> Colour:
    family = min(FAMILIES, key=lambda palette: min(_distance(old, colour) for colour in palette))
    others = [colour for colour in family if _distance(old, colour) > OTHER] or family
    colour = np.array(others[int(rng.integers(len(others)))]) * rng.uniform(0.92, 1.08)
    return tuple(np.clip(colour, 0.0, 1.0).round(3).tolist())


def _shade_of(old: Colour, new: dict[Colour, Colour]) -> Colour | None:
    """The same shade of the new colour of what `old` was a shade of."""
    for base, painted in new.items():
        ratio = np.array(old) / np.maximum(base, 1e-3)
        if np.ptp(ratio) < SHADED * ratio.max():
            return tuple(np.clip(np.array(painted) * ratio.mean(), 0.0, 1.0).round(3).tolist())
    return None


def _distance(a: Colour, b: Colour) -> float:
    return float(np.linalg.norm(np.subtract(a, b)))
