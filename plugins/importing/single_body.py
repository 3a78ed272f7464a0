"""A mesh file as an asset that does not move."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh

from stages.articulated.mesh_reader import convex_pieces, load_meshes
from stages.articulated.model import Link, RobotModel, Visual
from stages.contracts.errors import InputError
from stages.geometry.solids import MINIMUM_INERTIA, board_mass

FLAT_SHARE = 1e-5  # of its largest extent: what is thinner, whichever way it lies, has no inside


def read_mesh(path: Path, folder: Path) -> RobotModel:
    """A mesh file as a thing of one link, with the convex hulls of its bodies to collide.

    Raises:
        InputError: it cannot be read, or is flat.
    """
    return make_body(path, *load_meshes(path, folder))


def make_body(path: Path, meshes: Sequence[trimesh.Trimesh], remarks: Sequence[str] = ()) -> RobotModel:
    """The meshes of a file as one; `remarks`: what of them is lost, a line each.

    Raises:
        InputError: they are flat.
    """
    points = np.concatenate([mesh.vertices for mesh in meshes])
    across = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    if np.ptp(points @ across) < FLAT_SHARE * np.ptp(points, axis=0).max():
        raise InputError(path, "is flat.", "a mesh with some thickness", code="E-MODEL-FLAT")
    hull = trimesh.convex.convex_hull(points)
    pieces = [piece for mesh in meshes for piece in convex_pieces(mesh)]
    visuals = [Visual(mesh) for mesh in meshes]
    mass = board_mass(pieces, visuals)
    inertia = hull.moment_inertia * (mass / hull.volume) + MINIMUM_INERTIA * np.eye(3)
    base = Link("base", visuals, pieces, mass, hull.center_mass, inertia)
    return RobotModel(path.stem, {"base": base}, remarks=tuple(remarks))
