"""A mesh file as an asset that does not move."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh

from roomkin.stages.articulated.mesh_reader import convex_pieces, load_meshes
from roomkin.stages.articulated.model import Link, Matrix, RobotModel, Visual
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.solids import MINIMUM_INERTIA, board_mass

GROUND_HEIGHT, GROUND_AREA = 0.1, 2.0  # a ground is lower than this share of its sides, so much larger than the rest
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


def leave_out(robot: RobotModel, without: Sequence[str], path: Path) -> RobotModel:
    """The thing of a mesh file without some of its nodes.

    Raises:
        InputError: a name is that of none, or all are named.
    """
    meshes = [visual.mesh for visual in robot.links[robot.root].visuals]
    named = [set(mesh.metadata.get("nodes", [])) for mesh in meshes]
    known = set().union(*named)
    if unknown := [name for name in without if name not in known]:
        mend = f"name its nodes, {', '.join(sorted(known))}"[:300]
        what = f"has no node '{unknown[0]}', which asset.json leaves out."
        raise InputError(path, what, mend, code="E-MODEL-WITHOUT")
    kept = [mesh for mesh, names in zip(meshes, named, strict=True) if not names.intersection(without)]
    if not kept:
        raise InputError(path, "has no node that asset.json does not leave out.", "name fewer", code="E-MODEL-WITHOUT")
    return make_body(path, kept, [*robot.remarks, f"left out, as asset.json says: {', '.join(without)}"])


def find_ground(robot: RobotModel, height: int) -> str:
    """The node of a thing of one link that is a ground under the rest: flat, lowest, and much wider; empty: none."""
    corners: dict[str, list[Matrix]] = {}
    for visual in robot.links[robot.root].visuals if len(robot.links) == 1 else ():
        corners.setdefault(next(iter(visual.mesh.metadata.get("nodes", [])), ""), []).append(visual.mesh.bounds)
    for name in sorted(corners.keys() - {""}) if len(corners) > 1 else ():
        ground = np.concatenate(corners[name])
        rest = np.concatenate([box for other in corners if other != name for box in corners[other]])
        low, (sides, extents) = rest[:, height].min(), (np.ptp(points, axis=0) for points in (ground, rest))
        areas = [float(np.delete(each, height).prod()) for each in (sides, extents)]
        flat = sides[height] < GROUND_HEIGHT * np.delete(sides, height).min()
        if flat and ground[:, height].min() <= low and areas[0] > GROUND_AREA * areas[1]:
            return name
    return ""
