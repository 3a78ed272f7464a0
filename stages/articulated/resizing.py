"""An asset at another size: made again by its recipe's maker, else each extent scaled, at constant density."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from roomkin.stages.articulated.asset_folder import Description, read_asset, read_model, write_asset
from roomkin.stages.articulated.model import Link, Matrix, RobotModel, link_frames
from roomkin.stages.contracts.errors import InputError, ObjectError
from roomkin.stages.contracts.library import Asset, Finish, Recipe
from roomkin.stages.contracts.types import LARGEST, Vector
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.plugins import load_all


def stretch_model(robot: RobotModel, scale: tuple[float, float, float]) -> RobotModel:
    """The closed thing stretched along the root's axes: meshes, joint origins, sliding directions and ranges, and
    masses and inertias at constant density. Angles of hinges stay."""
    stretch = np.diag(np.asarray(scale, dtype=float))
    frames = link_frames(robot)
    local = {name: frame[:3, :3].T @ stretch @ frame[:3, :3] for name, frame in frames.items()}
    links = {name: _stretched_link(link, local[name]) for name, link in robot.links.items()}
    joints = []
    for joint in robot.joints:
        # the child's closed frame keeps its rotation and its origin is stretched; take the closed motion off again
        parent_from_child = joint.origin @ joint.motion(joint.lower)
        parent_from_child[:3, 3] = local[joint.parent] @ parent_from_child[:3, 3]
        if joint.type == "prismatic":
            slide = local[joint.child] @ joint.axis
            ratio = float(np.linalg.norm(slide))
            joint = replace(joint, axis=slide / ratio, lower=joint.lower * ratio, upper=joint.upper * ratio)
        origin = parent_from_child @ np.linalg.inv(joint.motion(joint.lower))
        joints.append(replace(joint, origin=origin))
    return replace(robot, links=links, joints=joints)


def _stretched_link(link: Link, A: Matrix) -> Link:
    """A link under a linear map of its frame; inertia through the second moments of mass."""
    volume = abs(float(np.linalg.det(A)))
    moments = 0.5 * np.trace(link.inertia) * np.eye(3) - link.inertia
    moments = volume * A @ moments @ A.T
    inertia = np.trace(moments) * np.eye(3) - moments
    return replace(link.map_linearly(make_transform(A, np.zeros(3))), mass=link.mass * volume, inertia=inertia)


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
