"""Collision shapes as upright prisms: exact for boxes and panels, a little generous for slanted legs."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPoint, Polygon
from shapely.geometry.base import BaseGeometry

from stages.generation.meshes import collision_pieces
from stages.generation.placed import Placed
from stages.geometry.frames import yaw_matrix


class Prism(NamedTuple):
    """A convex outline (n, 2) in the x-y plane, from height `low` to `high`."""

    outline: NDArray[np.float64]
    low: float
    high: float


def prism_of(vertices: NDArray[np.float64]) -> Prism | None:
    """The prism around the vertices (n, 3) of a convex piece; None if it has no area from above."""
    hull = MultiPoint(vertices[:, :2]).convex_hull
    if not isinstance(hull, Polygon):
        return None
    return Prism(np.array(hull.exterior.coords)[:-1], float(vertices[:, 2].min()), float(vertices[:, 2].max()))


def asset_prisms(folder: Path) -> list[Prism]:
    """Prisms of all collision shapes of an asset, in the asset frame."""
    pieces = (prism_of(np.asarray(mesh.vertices, dtype=float)) for mesh in collision_pieces(folder))
    return [prism for prism in pieces if prism is not None]


def placed_prisms(prisms: list[Prism], item: Placed) -> list[Prism]:
    """The prisms of an asset (asset frame) where the item stands (floor frame)."""
    middle = (np.asarray(item.asset.box_min) + np.asarray(item.asset.box_max)) / 2
    turn = yaw_matrix(item.box.yaw)[:2, :2]
    rise = item.center[2] - middle[2]
    return [
        Prism((prism.outline - middle[:2]) @ turn.T + item.center[:2], prism.low + rise, prism.high + rise)
        for prism in prisms
    ]


def forbidden_shifts(mover: list[Prism], others: list[Prism], touch: float) -> BaseGeometry:
    """All shifts (dx, dy) of `mover` at which it overlaps `others` by more than `touch` metres.

    Convex outlines A + t and B meet if and only if t lies in the Minkowski difference B - A, which is
    the hull of the differences of their vertices; so the shortest way out is the nearest point of a
    polygon's border, for all pieces at once.
    """
    regions = []
    for a in mover:
        for b in others:
            if min(a.high, b.high) - max(a.low, b.low) <= touch:
                continue
            differences = (b.outline[None] - a.outline[:, None]).reshape(-1, 2)
            regions.append(MultiPoint(differences).convex_hull.buffer(-touch, join_style="mitre"))
    return shapely.union_all(regions)
