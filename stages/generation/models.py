"""Models of the library as generation needs them: at the size of an object, as meshes, and as what collides.

In the asset frame, every joint closed. Asset folders never change: their names are keys of their content.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from shapely import MultiPoint, Polygon
from trimesh import Trimesh

from stages.articulated.asset_folder import read_model
from stages.articulated.forward_kinematics import link_frames
from stages.articulated.model import Link
from stages.contracts import Asset, read_json
from stages.generation.placed import Placed, Prism
from stages.geometry.estimate import BIN
from stages.procedural.resize import resized

FRONT = 0.3  # least share of its outline that a front fills


def at_its_size(item: Placed, cache: Path) -> Placed:
    """With a model that fills its box, and what of that collides."""
    folder = resized(item.folder, item.size.tolist(), cache)
    asset = read_json(Asset, folder / "asset.json")
    return replace(item, asset=asset, folder=folder, prisms=tuple(prisms_of(folder)))


def prisms_of(folder: Path) -> list[Prism]:
    """Upright prisms around all collision shapes of a model; without those that have no area from above."""
    found = []
    for mesh in collision_pieces(folder):
        vertices = np.asarray(mesh.vertices, dtype=float)
        hull = MultiPoint(vertices[:, :2]).convex_hull
        if isinstance(hull, Polygon):
            low, high = vertices[:, 2].min(), vertices[:, 2].max()
            found.append(Prism(np.array(hull.exterior.coords)[:-1], float(low), float(high), vertices))
    return found


def collision_pieces(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return [mesh for link in _closed_links(folder) for mesh in link.collisions]


def visual_meshes(folder: Path) -> list[Trimesh]:
    """What is seen, with its colours."""
    return [visual.painted() for link in _closed_links(folder) for visual in link.visuals]


@lru_cache(maxsize=64)
def _closed_links(folder: Path) -> list[Link]:
    """Links with their meshes in the asset frame."""
    robot = read_model(folder)
    frames = link_frames(robot)
    return [link.mapped(frames[link.name]) for link in robot.links.values()]


def beyond_front(meshes: Sequence[Trimesh]) -> float:
    """Metres by which a model's box reaches beyond the face that its front shows: its handles, the foot of a screen.

    That face is where most of what faces +x lies, in the front half.
    """
    bounds = np.array([mesh.bounds for mesh in meshes])
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    depths = high[0] - np.concatenate([mesh.triangles_center[:, 0] for mesh in meshes])
    areas = np.concatenate([mesh.area_faces * np.clip(mesh.face_normals[:, 0], 0, None) for mesh in meshes])
    half = (high[0] - low[0]) / 2
    counts, edges = np.histogram(depths, max(1, round(half / BIN)), (0, half), weights=areas)
    peak = int(np.argmax(counts))
    if counts[peak] < FRONT * np.prod((high - low)[1:]):
        return 0.0
    return float(np.average(depths, weights=areas * (depths >= edges[peak]) * (depths <= edges[peak + 1])))
