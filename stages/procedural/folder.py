"""Make an asset folder from a recipe."""

from pathlib import Path

import numpy as np

from stages.articulated.asset_folder import Description, write_asset
from stages.contracts.errors import InputError
from stages.contracts.library import Asset, Recipe
from stages.procedural.model import Model, Size, bounds, fitted
from stages.procedural.robot import robot_of

LICENCE = "CC0-1.0"
SETTLING_PASSES = 3  # generators miss the asked size by little (leaning legs...): aim again before scaling


def build(
    recipe: Recipe, size: Size | None, out: Path, id: str, category: str, provenance: str = "procedural"
) -> Asset:
    """Make a procedural asset whose closed box is exactly `size` (None: the recipe's own) in the folder `out`.

    The folder appears whole or not at all; an old one is replaced.

    Raises:
        InputError: the recipe names no known generator or a bad size.
    """
    model = generate(recipe, size)
    about = Description(
        id, category, LICENCE, provenance, symmetry=model.symmetry, placement=model.placement, recipe=recipe
    )
    return write_asset(robot_of(model, id), out, about)


def generate(recipe: Recipe, size: Size | None = None) -> Model:
    """The model of a recipe at a size, fitted to it exactly."""
    from stages.procedural.catalogue import GENERATORS

    if recipe.generator not in GENERATORS:
        raise InputError(
            "recipe", f"unknown generator '{recipe.generator}'.", f"one of {', '.join(sorted(GENERATORS))}"
        )
    x, y, z = np.asarray(recipe.parameters["size"] if size is None else size, dtype=float).tolist()
    wanted = (x, y, z)
    if min(wanted) <= 0:
        raise InputError("recipe", f"size {wanted} is not positive.")
    aim = wanted
    for _ in range(SETTLING_PASSES):
        model = GENERATORS[recipe.generator](aim, recipe.parameters)
        low, high = bounds(model)
        if max(abs(high - low - wanted)) < 1e-4:
            break
        a, b, c = (aim * (wanted / (high - low))).tolist()
        aim = (a, b, c)
    return fitted(model, wanted)
