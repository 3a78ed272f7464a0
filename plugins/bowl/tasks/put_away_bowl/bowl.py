"""The bowl: an asset folder, procedural unless one is given, and how large it may be to go into a drawer."""

import hashlib
from functools import cache
from pathlib import Path

import numpy as np
import trimesh

from stages.articulated.asset_folder import Description, read_model, write_asset
from stages.procedural.categories.vessels import hollow
from stages.procedural.colours import WOODS
from stages.procedural.folder import LICENCE
from stages.procedural.model import WOOD, Model, Part, part
from stages.procedural.robot import robot_of
from stages.procedural.shapes import slab
from stages.simulation.kinematics import Array
from stages.simulation.region import Region, headroom, level_region
from stages.simulation.robot import cache_folder
from stages.simulation.target import Target

PROFILE = [(0.039, 0.0), (0.0598, 0.02), (0.065, 0.05)]  # of the default bowl: (radius, height) of its outside, metres
WALL = 0.012  # metres; as of wood, as PhysX lets go of thin walls
STAND = (((0.17, 0.17, 0.02), 0.0), ((0.06, 0.06, 0.5), -0.02))  # boxes: size, height of their tops; metres
SCALE = (0.85, 1.15)  # of the bowl, uniform
AROUND, ABOVE = 0.04, 0.015  # metres kept free on each side of a bowl in a drawer, and above it


@cache
def default_bowl() -> Path:
    """Folder of the bowl that is used unless another is given; made once and kept between runs."""
    light = list(WOODS[0].colour)
    return _made("bowl", hollow(PROFILE, WALL, light, light, WOOD))


@cache
def stand() -> Path:
    """Folder of what the bowl stands on: a plate on a column, its top at z = 0."""
    dark = list(WOODS[1].colour)
    return _made("stand", [part(slab((0, 0, top - size[2] / 2), size), dark) for size, top in STAND])


def _made(name: str, parts: list[Part]) -> Path:
    """Folder of an asset of these parts, in the cache; its name is a key of them."""
    shapes = [(part.mesh.vertices.round(6).tolist(), part.colour, part.density) for part in parts]
    folder = cache_folder() / f"{name}-{hashlib.sha256(repr(shapes).encode()).hexdigest()[:16]}"
    if not (folder / "asset.json").exists():
        model = Model(parts, placement="object")
        write_asset(robot_of(model, name), folder, Description(name, name, LICENCE, "procedural"))
    return folder


@cache
def seen_mesh(folder: Path) -> trimesh.Trimesh:
    """What is seen of an asset of one body, in its own frame at its own size; what collides may have faces inside."""
    visuals = [visual.mesh for link in read_model(folder).links.values() for visual in link.visuals]
    mesh = trimesh.util.concatenate(visuals)
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def sampled_scale(extents: Array) -> float:
    """The scale of a bowl beside an object with these extents (3,): the same object, the same bowl."""
    entropy = [round(1e4 * extent) for extent in extents]
    return float(np.random.default_rng((*entropy, 47)).uniform(*SCALE))


def fitting_scale(extents: Array, floor: Region, target: Target) -> float:
    """The largest scale at which a bowl with these extents (3,) goes through an opened drawer and fits into it shut.

    Args:
        floor: of the drawer.
        target: the drawer's joint.
    """
    across = 2 * float(floor.room.max()) - AROUND
    along = 0.9 * (target.upper - target.lower) - 2 * AROUND
    up = headroom(floor, target.fixed) - ABOVE
    return min(min(across, along) / float(extents[:2].max()), up / float(extents[2]))


def drawer_floor(target: Target) -> Region | None:
    """The floor of a drawer, in the asset frame with the drawer shut; None if it has none that is level."""
    return level_region(target.moving)
