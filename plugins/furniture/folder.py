"""From a recipe to an asset folder: a robot with a link per moving part, masses of its solids, and textures."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from pydantic import ValidationError
from scipy.spatial import QhullError
from trimesh import Trimesh

from roomkin.plugins.furniture.model import Model, Moving, Part, Size, bounds, fit_model, parts_of
from roomkin.plugins.furniture.recipe import Generator
from roomkin.plugins.furniture.textures import texture_of
from roomkin.stages.articulated.asset_folder import Description, write_asset
from roomkin.stages.articulated.mesh_writer import is_box
from roomkin.stages.articulated.model import JointModel, Link, Matrix, RobotModel, Visual
from roomkin.stages.articulated.resizing import SizedModel
from roomkin.stages.articulated.urdf_tree import THIN
from roomkin.stages.contracts.errors import InputError, ObjectError, explain, first_error
from roomkin.stages.contracts.images import GOLDEN
from roomkin.stages.contracts.library import Asset, Recipe
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.geometry.solids import MINIMUM_INERTIA

BASE = "base"
SLIM = 0.03  # metres: a part that is no wider in two directions shows its color alone


def robot_of(model: Model, name: str) -> RobotModel:
    """The model with its base as root; every door and drawer is a link with its origin at the joint."""
    links = {BASE: _link(BASE, model.base, np.zeros(3))}
    links |= {moving.name: _link(moving.name, moving.parts, np.array(moving.origin)) for moving in model.moving}
    return RobotModel(name, links, [_joint(moving) for moving in model.moving])


def _link(name: str, parts: list[Part], origin: Matrix) -> Link:
    mass, center, inertia = mass_properties(parts)
    visuals = [_visual(part, origin, number) for number, part in enumerate(parts)]
    pieces = [
        visual.mesh if piece is part.mesh else _shift_mesh(piece, origin)
        for part, visual in zip(parts, visuals, strict=True)
        for piece in part.pieces
    ]
    return Link(name, visuals, pieces, mass, center - origin, inertia)


def _visual(part: Part, origin: Matrix, number: int) -> Visual:
    """The visual of a part; no two neighbours show the same piece of their texture."""
    slim = np.sort(part.mesh.extents)[1] < SLIM
    start = (number * GOLDEN % 1, number * GOLDEN**2 % 1)
    texture = None if slim else texture_of(part.finish)
    return Visual(_shift_mesh(part.mesh, origin), (*part.color, 1.0), not part.smooth, texture, start)


def _joint(moving: Moving) -> JointModel:
    """The joint of a moving part; a handle that sticks out is part of the moving link."""
    return JointModel(
        name=f"{moving.name}_joint", type=PARTS[moving.part_type].joint, parent=BASE, child=moving.name,
        origin=make_transform(np.eye(3), moving.origin), axis=np.array(moving.axis), lower=0.0, upper=moving.upper,
        part_type=moving.part_type, handle_link=moving.name if moving.handle else None, handle=moving.handle,
    )  # fmt: skip


def _shift_mesh(mesh: Trimesh, origin: Matrix) -> Trimesh:
    """The mesh seen from `origin`."""
    return Trimesh(mesh.vertices - origin, mesh.faces, process=False) if origin.any() else mesh


def mass_properties(parts: list[Part]) -> tuple[float, Matrix, Matrix]:
    """Mass (kg), center of mass (asset frame) and inertia about it, (3, 3), of solids of uniform density."""
    solids = [_solid(part.mesh) for part in parts]
    masses = np.array([solid[0] * part.density for solid, part in zip(solids, parts, strict=True)])
    centers = np.array([solid[1] for solid in solids])
    mass = float(masses.sum())
    center = masses @ centers / mass
    inertia = np.zeros((3, 3))
    for part, solid, m, own in zip(parts, solids, masses, centers, strict=True):
        offset = own - center
        inertia += solid[2] * part.density
        inertia += m * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, center, inertia + MINIMUM_INERTIA * np.eye(3)


def _solid(mesh: Trimesh) -> tuple[float, Matrix, Matrix]:
    """Volume, center and second moments about it, (3, 3), of a solid of density 1."""
    if not is_box(mesh):
        return abs(mesh.volume), mesh.center_mass, mesh.moment_inertia
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    volume, squares = float(np.prod(high - low)), (high - low) ** 2
    return volume, (low + high) / 2, np.diag(volume / 12 * (squares.sum() - squares))


LICENCE = "CC0-1.0"
ROOM = (0.0, 0.05, 0.1, 0.2, 0.4)  # metres: extents in which ever more boards fit


def build(
    recipe: Recipe, size: Size | None, out: Path, id: str, category: str, provenance: str = "procedural"
) -> Asset:
    """Make a procedural asset whose closed box is exactly `size` (None: the recipe's own) in the folder `out`.

    The folder appears whole or not at all; an old one is replaced.

    Raises:
        InputError: the recipe names no known generator or a bad size.
    """
    robot, about = make_model(recipe, size, Description(id, category, LICENCE, provenance))
    return write_asset(robot, out, about)


def make_model(recipe: Recipe, size: Size | None, about: Description) -> SizedModel:
    """A model whose closed box has a size (None: the recipe's own); placement and symmetry of `about` are replaced.

    Raises:
        InputError: the recipe names no known generator or a bad size.
    """
    model = generate(recipe, size)
    about = replace(about, symmetry=model.symmetry, placement=model.placement, recipe=recipe)
    return SizedModel(robot_of(model, about.id), about)


def generate(recipe: Recipe, size: Size | None = None) -> Model:
    """The model of a recipe at a size, fitted to it exactly.

    Raises:
        InputError: no such generator, a bad size, or a parameter that is missing, unknown or out of bounds.
        ObjectError: they make no model of that size.
    """
    from roomkin.plugins.furniture.catalogue import GENERATORS

    if recipe.generator not in GENERATORS:
        names = f"one of {', '.join(sorted(GENERATORS))}"
        raise InputError("recipe", f"unknown generator '{recipe.generator}'.", names, code="E-RECIPE-PARAMETER")
    wanted = _size(recipe, size)
    parameters = {key: value for key, value in recipe.parameters.items() if key != "size"}
    where = f"recipe of a {recipe.generator}"
    try:
        return _generate_model(GENERATORS[recipe.generator].model_validate(parameters), wanted)
    except ValidationError as error:
        raise InputError(where, f"parameter {first_error(error)}.", code="E-RECIPE-PARAMETER") from None
    except (ValueError, IndexError, ArithmeticError, QhullError) as error:
        reason = (str(error).splitlines() or [explain(error)])[0][:200]
        raise ObjectError(where, f"its parameters make no model: {reason}.", code="E-RECIPE-PARAMETER") from None


def _size(recipe: Recipe, size: Size | None) -> Size:
    """The size to make, checked."""
    asked = recipe.parameters.get("size") if size is None else size
    try:
        x, y, z = np.asarray(asked, dtype=float).tolist()
    except (TypeError, ValueError):
        raise InputError("recipe", f"size {asked!r} is not three numbers.", code="E-RECIPE-PARAMETER") from None
    if not all(0 < extent <= LARGEST for extent in (x, y, z)):
        fault = f"size {(x, y, z)} is not positive, or larger than {LARGEST:g} m."
        raise InputError("recipe", fault, code="E-RECIPE-PARAMETER")
    return (x, y, z)


def _generate_model(generator: Generator, wanted: Size) -> Model:
    """The model at a size; where its boards do not fit in, that of a size where they do, scaled."""
    for room in ROOM:
        x, y, z = np.maximum(wanted, room).tolist()
        try:
            model = _fit_recipe(generator, (x, y, z))
        except (ValueError, IndexError, ArithmeticError, QhullError):
            if room == ROOM[-1]:
                raise
            continue
        if _is_sound(model):
            break
    return fit_model(model, wanted)


def _is_sound(model: Model) -> bool:
    """Whether every solid is one and everything that moves has somewhere to go."""
    solids = all(np.ptp(mesh.vertices, axis=0).min() > THIN for part in parts_of(model) for mesh in part.pieces)
    return solids and all(moving.upper > 0 for moving in model.moving)


def _fit_recipe(generator: Generator, wanted: Size) -> Model:
    aim = wanted
    for _ in range(3):  # generators miss the asked size by little (leaning legs...): aim again before scaling
        model = generator.build(aim)
        low, high = bounds(model)
        if max(abs(high - low - wanted)) < 1e-4:
            break
        a, b, c = (aim * (wanted / (high - low))).tolist()
        aim = (a, b, c)
    return fit_model(model, wanted)
