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

from stages.articulated.asset_folder import read_model, write_asset
from stages.articulated.forward_kinematics import closed_box, link_frames
from stages.articulated.model import Link, RobotModel
from stages.articulated.resizing import has_size, resize_model
from stages.articulated.urdf_writer import as_written
from stages.generation.placed import Placed, Prism
from stages.geometry.estimate import BIN

FRONT = 0.3  # least share of its outline that a front fills


def resize(item: Placed) -> Placed:
    """With a model that fills its box, and what of that collides."""
    if has_size(item.asset, item.size.tolist()):
        return replace(item, prisms=tuple(prisms_of(read_model(item.folder))))
    sized = resize_model(item.folder, item.asset, item.size.tolist())
    low, high = closed_box(sized.robot).round(6)
    asset = item.asset.model_copy(
        update={"box_min": tuple(low), "box_max": tuple(high), "mass": round(sized.robot.mass, 4)}
    )
    return replace(item, asset=asset, sized=sized, prisms=tuple(prisms_of(sized.robot)))


def write_models(items: Sequence[Placed], out: Path) -> list[Placed]:
    """The items with folders of their resized models, for simulators that read files, in the folder `out`."""
    for item in items:
        if item.sized is not None:
            write_asset(item.sized.robot, out / item.id, item.sized.about)
    return [item if item.sized is None else replace(item, folder=out / item.id) for item in items]


def prisms_of(robot: RobotModel) -> list[Prism]:
    """Upright prisms around all collision shapes of a model, closed; without those that have no area from above.

    To the digits of its files: what physics reads.
    """
    found = []
    for piece in [mesh for link in closed_links(as_written(robot)) for mesh in link.collisions]:
        vertices = np.asarray(piece.vertices, dtype=float)
        hull = MultiPoint(vertices[:, :2]).convex_hull
        if isinstance(hull, Polygon):
            low, high = vertices[:, 2].min(), vertices[:, 2].max()
            found.append(Prism(np.array(hull.exterior.coords)[:-1], float(low), float(high), vertices))
    return found


def collision_pieces(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return [mesh for link in _read_links(folder) for mesh in link.collisions]


def visual_meshes(folder: Path) -> list[Trimesh]:
    """What is seen, with its colours."""
    return [visual.painted() for link in _read_links(folder) for visual in link.visuals]


@lru_cache(maxsize=64)
def _read_links(folder: Path) -> list[Link]:
    return closed_links(read_model(folder))


def closed_links(robot: RobotModel) -> list[Link]:
    """Links with their meshes in the asset frame."""
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
