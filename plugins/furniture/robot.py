"""A procedural model as an articulation: one link per moving part, masses and inertias from the solids."""

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.model import Model, Moving, Part
from roomkin.plugins.furniture.textures import texture_of
from roomkin.stages.articulated.mesh_writer import is_box
from roomkin.stages.articulated.model import JointModel, Link, Matrix, RobotModel, Visual
from roomkin.stages.contracts.images import GOLDEN
from roomkin.stages.contracts.parts import PARTS
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
        name=f"{moving.name}_joint",
        type=PARTS[moving.part_type].joint,
        parent=BASE,
        child=moving.name,
        origin=make_transform(np.eye(3), moving.origin),
        axis=np.array(moving.axis),
        lower=0.0,
        upper=moving.upper,
        part_type=moving.part_type,
        handle_link=moving.name if moving.handle else None,
        handle=moving.handle,
    )


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
