"""The bowl: an asset folder, and how large it may be to go into a drawer."""

import hashlib
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh

from roomkin.plugins.bowl.region import Region, measure_headroom
from roomkin.stages.articulated.asset_folder import Description, read_model, write_asset
from roomkin.stages.articulated.model import RGBA, Link, RobotModel, Visual
from roomkin.stages.geometry.solids import DENSITY, MINIMUM_INERTIA
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import cache_folder
from roomkin.stages.simulation.target import Target

PROFILE = [(0.039, 0.0), (0.0598, 0.02), (0.065, 0.05)]  # of the default bowl: (radius, height) of its outside, metres
WALL = 0.012  # metres; as of wood, as PhysX lets go of thin walls
STAND = (((0.17, 0.17, 0.02), 0.0), ((0.06, 0.06, 0.5), -0.02))  # boxes: size, height of their tops; metres
LIGHT_WOOD, DARK_WOOD = (0.55, 0.36, 0.2, 1.0), (0.4, 0.22, 0.11, 1.0)  # linear
SCALE = (0.85, 1.15)  # of the bowl, uniform
AROUND, ABOVE = 0.04, 0.015  # metres kept free on each side of a bowl in a drawer, and above it


@cache
def default_bowl() -> Path:
    """Folder of the bowl; made once and kept between runs."""
    inner = [(radius - WALL, max(height, WALL)) for radius, height in PROFILE]
    inner[-1] = inner[-1][0], PROFILE[-1][1]
    body = trimesh.creation.revolve([(0, 0), *PROFILE, *inner[::-1], (0, WALL)], sections=24)
    base = trimesh.creation.revolve([(0, 0), (PROFILE[0][0], 0), inner[0], (0, WALL)], sections=16)
    return _write("bowl", [body], [base, *_wedges(inner)], LIGHT_WOOD)


def _wedges(inner: list[tuple[float, float]], count: int = 12) -> list[trimesh.Trimesh]:
    """Convex pieces of the wall between the profile and the one inside it."""
    angles = 2 * np.pi * np.arange(count + 1) / count
    return [
        trimesh.convex.convex_hull(
            np.array([(r * np.cos(t), r * np.sin(t), z) for t in turn for r, z in (*outside, *inside)])
        )
        for outside, inside in zip(pairwise(PROFILE), pairwise(inner), strict=True)
        for turn in pairwise(angles)
    ]


@cache
def stand() -> Path:
    """Folder of what the bowl stands on: a plate on a column, its top at z = 0."""
    boxes = [trimesh.creation.box(size) for size, _ in STAND]
    for box, (size, top) in zip(boxes, STAND, strict=True):
        box.apply_translation((0, 0, top - size[2] / 2))
    return _write("stand", boxes, boxes, DARK_WOOD)


def _write(name: str, solids: list[trimesh.Trimesh], pieces: list[trimesh.Trimesh], color: RGBA) -> Path:
    """Folder of a wooden asset in the cache, its name a key of solids and of the convex pieces that collide."""
    shapes = [(mesh.vertices.round(6).tolist(), color) for mesh in (*solids, *pieces)]
    folder = cache_folder() / f"{name}-{hashlib.sha256(repr(shapes).encode()).hexdigest()[:16]}"
    if not (folder / "asset.json").exists():
        whole = trimesh.util.concatenate(solids)
        assert isinstance(whole, trimesh.Trimesh)
        visuals = [Visual(mesh, color, flat=len(mesh.vertices) == 8) for mesh in solids]
        inertia = DENSITY * whole.moment_inertia + MINIMUM_INERTIA * np.eye(3)
        link = Link("base", visuals, pieces, DENSITY * whole.volume, whole.center_mass, inertia)
        about = Description(name, name, "CC0-1.0", "procedural")
        write_asset(RobotModel(name, {"base": link}, []), folder, about)
    return folder


@cache
def load_visual_mesh(folder: Path) -> trimesh.Trimesh:
    """The visible mesh of an asset of one body, in its own frame and size; what collides may have faces inside."""
    visuals = [visual.mesh for link in read_model(folder).links.values() for visual in link.visuals]
    mesh = trimesh.util.concatenate(visuals)
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def sample_scale(extents: Array) -> float:
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
    up = measure_headroom(floor, target.fixed) - ABOVE
    return min(min(across, along) / float(extents[:2].max()), up / float(extents[2]))
