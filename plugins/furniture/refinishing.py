"""The same model in another finish: other colours and textures, the same geometry (protocol `recoloured`)."""

from typing import Any

import numpy as np

from plugins.furniture.colours import ALTERNATIVES, pick
from plugins.furniture.finishes import Finish, Surface, finish_of
from stages.contracts.library import Recipe

FIXED = {"screen_colour", "panel_colour", "inside_colour"}  # the same on every model
OTHER = 0.12  # distance from the old colour from which a colour is another one
SHADED = 0.02  # a colour that is a multiple of another, to this relative accuracy, stays its shade


def refinish(recipe: Recipe, rng: np.random.Generator) -> Recipe:
    """The recipe with another finish for every part, of what such a material is sold in.

    What was of one finish stays of one finish, a shade stays a shade of the other's new colour.
    """
    new: dict[Finish, Finish] = {}

    def repaint(value: Surface) -> str:
        old = finish_of(value)
        if old not in new:
            new[old] = _shade_of(old, new) or _another(old, rng)
        return str(new[old])

    parameters: dict[str, Any] = dict(recipe.parameters)
    for key, value in parameters.items():
        if is_finish(key):
            parameters[key] = [repaint(each) for each in value] if key == "colours" else repaint(value)
    return recipe.model_copy(update={"parameters": parameters})


def is_finish(key: str) -> bool:
    """Whether a parameter of a recipe is a finish (or several) that may be another one."""
    return key not in FIXED and (key in ("colours", "inside") or "colour" in key)


def _another(old: Finish, rng: np.random.Generator) -> Finish:
    family = ALTERNATIVES[old.material]
    others = [finish for finish in family if np.linalg.norm(np.subtract(finish.colour, old.colour)) > OTHER]
    return finish_of(pick(rng, others or family))


def _shade_of(old: Finish, new: dict[Finish, Finish]) -> Finish | None:
    """The same shade of the new finish of what `old` was a shade of."""
    for base, painted in new.items():
        ratio = np.array(old.colour) / np.maximum(base.colour, 1e-3)
        if old.material == base.material and np.ptp(ratio) < SHADED * ratio.max():
            return painted.change_colour([float(ratio.mean()) * channel for channel in painted.colour])
    return None
