"""Models of the library as generation needs them: at the size of an object, as meshes, and as what collides.

In the asset frame, every joint closed. Asset folders never change: their names are keys of their content.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from shapely import MultiPoint, Polygon
from trimesh import Trimesh

from stages.articulated.asset_folder import read_asset, read_model, urdf_of
from stages.articulated.forward_kinematics import frames_of, measure_closed_box, read_closed_links
from stages.articulated.model import Link, Visual
from stages.articulated.resizing import has_size, resize_model
from stages.articulated.urdf_reader import UrdfReader
from stages.articulated.urdf_writer import as_written
from stages.generation.placed import Placed, Prism


def resize(item: Placed) -> Placed:
    """The item with a model of the size of its box and that model's collision prisms, rounded as in its files."""
    if has_size(item.asset, item.size.tolist()):
        return replace(item, prisms=to_prisms(read_collisions(item.folder)))
    sized = resize_model(item.folder, item.asset, item.size.tolist())
    low, high = (measure_closed_box(sized.robot).round(6) + 0.0).tolist()
    mass = round(sized.robot.mass, 4)
    asset = item.asset.model_copy(update={"box_min": tuple(low), "box_max": tuple(high), "mass": mass})
    pieces = [mesh for link in read_closed_links(as_written(sized.robot)) for mesh in link.collisions]
    return replace(item, asset=asset, sized=sized, prisms=to_prisms(pieces))


def to_prisms(pieces: Iterable[Trimesh]) -> tuple[Prism, ...]:
    """Upright prisms around convex pieces; without those that have no area from above."""
    found = []
    for piece in pieces:
        vertices = np.asarray(piece.vertices, dtype=float)
        hull = MultiPoint(vertices[:, :2]).convex_hull
        if isinstance(hull, Polygon):
            low, high = vertices[:, 2].min(), vertices[:, 2].max()
            found.append(Prism(np.array(hull.exterior.coords)[:-1], float(low), float(high), vertices))
    return tuple(found)


def read_visuals(folder: Path) -> list[Visual]:
    """What is seen of a model, in the asset frame; as of `read_links`, in half the time."""
    reader = UrdfReader(urdf_of(folder, read_asset(folder)), folder)
    frames = frames_of(reader.tree.root, reader.joints)
    return [visual.transform(frames[name]) for name in reader.tree.links for visual in reader.visuals(name)]


@lru_cache(maxsize=64)
def read_links(folder: Path) -> list[Link]:
    """Links of a model with their meshes in the asset frame."""
    return read_closed_links(read_model(folder))


def read_collisions(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return [mesh for link in read_links(folder) for mesh in link.collisions]
