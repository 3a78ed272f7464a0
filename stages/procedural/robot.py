"""A procedural model as an articulation: one link per moving part, masses and inertias from the solids."""

import numpy as np
from trimesh import Trimesh

from stages.articulated.model import JointModel, Link, Matrix, RobotModel, Visual
from stages.geometry.frames import rigid
from stages.procedural.model import Model, Moving, Part

BASE = "base"
MINIMUM_INERTIA = 1e-7


def robot_of(model: Model, name: str) -> RobotModel:
    """The model with its base as root; every door and drawer is a link with its origin at the joint."""
    links = {BASE: _link(BASE, model.base, np.zeros(3))}
    links |= {moving.name: _link(moving.name, moving.parts, np.array(moving.origin)) for moving in model.moving}
    return RobotModel(name, links, [_joint(moving) for moving in model.moving])


def _link(name: str, parts: list[Part], origin: Matrix) -> Link:
    mass, center, inertia = mass_properties(parts)
    visuals = [Visual(_shifted(part.mesh, origin), (*part.colour, 1.0), flat=not part.smooth) for part in parts]
    pieces = [_shifted(piece, origin) for part in parts for piece in part.pieces]
    return Link(name, visuals, pieces, mass, center - origin, inertia)


def _joint(moving: Moving) -> JointModel:
    """The joint of a moving part; a handle that sticks out is part of the moving link."""
    return JointModel(
        name=f"{moving.name}_joint",
        type="revolute" if moving.role == "door" else "prismatic",
        parent=BASE,
        child=moving.name,
        origin=rigid(np.eye(3), moving.origin),
        axis=np.array(moving.axis),
        lower=0.0,
        upper=moving.upper,
        role=moving.role,
        handle_link=moving.name if moving.handle else None,
        handle=moving.handle,
    )


def _shifted(mesh: Trimesh, origin: Matrix) -> Trimesh:
    """The mesh seen from `origin`."""
    return Trimesh(mesh.vertices - origin, mesh.faces, process=False) if origin.any() else mesh


def mass_properties(parts: list[Part]) -> tuple[float, Matrix, Matrix]:
    """Mass (kg), centre of mass (asset frame) and inertia about it, (3, 3), of solids of uniform density."""
    masses = np.array([abs(part.mesh.volume) * part.density for part in parts])
    centers = np.array([part.mesh.center_mass for part in parts])
    mass = float(masses.sum())
    center = masses @ centers / mass
    inertia = np.zeros((3, 3))
    for part, m, own in zip(parts, masses, centers, strict=True):
        offset = own - center
        inertia += part.mesh.moment_inertia * part.density
        inertia += m * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, center, inertia + MINIMUM_INERTIA * np.eye(3)
