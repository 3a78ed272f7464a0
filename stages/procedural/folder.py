"""Make an asset folder from a recipe."""

from pathlib import Path

import numpy as np

from stages.articulated.asset_folder import atomic_folder, checksum
from stages.contracts.errors import InputError
from stages.contracts.files import write_json
from stages.contracts.library import Asset, Joint, Recipe
from stages.procedural.model import Model, Size, bounds, fitted
from stages.procedural.urdf import write_urdf

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
    with atomic_folder(out) as folder:
        mass = write_urdf(model, folder, id)
        low, high = bounds(model)
        asset = Asset(
            id=id,
            category=category,
            box_min=tuple(low.round(6).tolist()),
            box_max=tuple(high.round(6).tolist()),
            mass=round(mass, 4),
            joints=joints_of(model),
            doors=sum(moving.role == "door" for moving in model.moving),
            drawers=sum(moving.role == "drawer" for moving in model.moving),
            symmetry=model.symmetry,
            placement=model.placement,
            recipe=recipe,
            licence=LICENCE,
            provenance=provenance,
            checksum=checksum(folder),
        )
        write_json(folder / "asset.json", asset)
    return asset


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


def joints_of(model: Model) -> list[Joint]:
    """The contract's joints of a model; the handle is part of the moving link."""
    return [
        Joint(
            name=f"{moving.name}_joint",
            type="revolute" if moving.role == "door" else "prismatic",
            role=moving.role,
            parent="base",
            link=moving.name,
            axis=moving.axis,
            lower=0.0,
            upper=round(moving.upper, 5),
            handle_link=None if moving.handle in (None, "recessed") else moving.name,
            handle=moving.handle,
        )
        for moving in model.moving
    ]
