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

from roomkin.stages.articulated.asset_folder import read_model
from roomkin.stages.articulated.model import list_collisions, measure_closed_box
from roomkin.stages.articulated.resizing import has_size, resize_model
from roomkin.stages.articulated.urdf_writer import as_written
from roomkin.stages.generation.placed import Placed, Prism


def resize(item: Placed) -> Placed:
    """The item with a model of the size of its box and that model's collision prisms, rounded as in its files."""
    if has_size(item.asset, item.size.tolist()):
        return replace(item, prisms=to_prisms(read_collisions(item.folder)))
    robot = resize_model(item.folder, item.asset, item.size.tolist()).robot
    pieces = list_collisions(as_written(robot))
    low, high = (measure_closed_box(robot).round(6) + 0.0).tolist()
    sized = {"box_min": tuple(low), "box_max": tuple(high), "mass": round(robot.mass, 4)}
    return replace(item, asset=item.asset.model_copy(update=sized), robot=robot, prisms=to_prisms(pieces))


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


@lru_cache(maxsize=64)
def read_collisions(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return list_collisions(read_model(folder))
