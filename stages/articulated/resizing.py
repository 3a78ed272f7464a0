"""The same asset at another size: models that have a recipe are made again by their maker, others are stretched."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from roomkin.stages.articulated.asset_folder import Description, read_asset, read_model, write_asset
from roomkin.stages.articulated.model import RobotModel
from roomkin.stages.articulated.stretching import stretch_model
from roomkin.stages.contracts.errors import InputError, ObjectError
from roomkin.stages.contracts.library import Asset, Finish, Recipe, Vector
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.plugins import load_all

SAME_SIZE = 5e-4  # metres: a size this near to the native one is left alone


class SizedModel(NamedTuple):
    """A model at a size, and what an asset folder says of it."""

    robot: RobotModel
    about: Description


class Maker(Protocol):
    """Makes models by recipes."""

    def make_model(self, recipe: Recipe, size: Vector, about: Description) -> SizedModel:
        """A model whose closed box has the size; placement and symmetry of `about` are replaced."""
        ...

    def paint(self, recipe: Recipe, color: tuple[float, float, float]) -> Recipe:
        """The recipe of the same model whose main color is another one, linear rgb."""
        ...

    def refinish(self, recipe: Recipe, rng: np.random.Generator) -> Recipe:
        """The recipe of the same model in other colors and textures."""
        ...


def load_maker() -> Maker:
    """The maker of recipes, of the package that has one.

    Raises:
        InputError: none has.
    """
    makers: list[type[Maker]] = load_all("makers")
    if not makers:
        raise InputError("recipe", "no package makes models by it.", "plugins/furniture does", code="E-MODEL-MAKER")
    return makers[0]()


def has_size(asset: Asset, size: Sequence[float]) -> bool:
    """Whether an asset has a size already."""
    return max(abs(a - b) for a, b in zip(size, asset.size, strict=True)) < SAME_SIZE


def resize_model(folder: Path, asset: Asset, size: Sequence[float], by_recipe: bool = True) -> SizedModel:
    """The model of an asset folder with a closed box of exactly `size` (metres, own axes).

    Args:
        by_recipe: make a model that has a recipe anew; else everything in it is scaled per axis.

    Raises:
        ObjectError: the size is not positive, or not of this world.
    """
    x, y, z = (float(value) for value in size)
    if not all(0 < extent <= LARGEST for extent in (x, y, z)):
        fix = f"all extents must be positive, {LARGEST:g} m at most"
        raise ObjectError(folder, f"cannot be resized to {x:g} x {y:g} x {z:g} m.", fix, code="E-MODEL-SIZE")
    about = Description(asset.id, asset.category, asset.licence, asset.provenance, asset.symmetry, asset.placement)
    if by_recipe and asset.recipe is not None:
        return load_maker().make_model(asset.recipe, (x, y, z), about)
    a, b, c = (np.array([x, y, z]) / np.maximum(asset.size, 1e-9)).tolist()
    return SizedModel(stretch_model(read_model(folder), (a, b, c)), about)


def resize_asset(folder: Path, size: Sequence[float], out: Path, finish: Finish | None = None) -> Path:
    """A folder, inside `out`, of an asset at a size, as `resize_model` has it; its own one if it has that size.

    The folder's name is a key of asset, size and finish; one that is there already is used as it is.

    Args:
        finish: parameters of its recipe that are to be others.
    """
    asset = read_asset(folder)
    if has_size(asset, size) and not finish:
        return Path(folder)
    asset = asset.change_finish(finish or {})
    parts = [asset.id, asset.checksum, [round(float(value), 5) for value in size], *([finish] if finish else [])]
    key = json.dumps(parts, sort_keys=True)
    sized = Path(out) / f"{asset.id}-{hashlib.sha256(key.encode()).hexdigest()[:12]}"
    if not (sized / "asset.json").exists():
        robot, about = resize_model(folder, asset, size)
        write_asset(robot, sized, about)
    return sized
