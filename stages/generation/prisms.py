"""Collision shapes as upright prisms: exact for boxes and panels, a little generous for slanted legs."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPoint, MultiPolygon, Polygon, affinity
from shapely.geometry.base import BaseGeometry

from stages.generation.meshes import collision_pieces
from stages.generation.placed import Placed
from stages.geometry.boxes import footprint
from stages.geometry.frames import yaw_matrix

LEVEL = 0.01  # metres: tops that differ by less are one surface
EVEN = 0.001  # metres below the highest of them, at which a piece still carries: a door's upper edge does not
HOLDS = 0.5  # of half the width of what it is to carry: a narrower surface (a back, a rail) carries nothing
GRID = 1e-6  # metres to which outlines are cut and joined: overlays of floating point numbers may fail
STEADY = 0.1  # of the width of what stands near an edge: the least distance of its centre from that edge


class Prism(NamedTuple):
    """A convex outline (n, 2) in the x-y plane, from height `low` to `high`; `piece`: what it is around, (m, 3)."""

    outline: NDArray[np.float64]
    low: float
    high: float
    piece: NDArray[np.float64] | None = None

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Of the convex piece, (m, 3); of the prism itself if it is around none."""
        if self.piece is not None:
            return self.piece
        return np.concatenate([np.column_stack([self.outline, np.full(len(self.outline), z)]) for z in self[1:3]])


def prism_of(vertices: NDArray[np.float64]) -> Prism | None:
    """The prism around the vertices (n, 3) of a convex piece; None if it has no area from above."""
    hull = MultiPoint(vertices[:, :2]).convex_hull
    if not isinstance(hull, Polygon):
        return None
    low, high = vertices[:, 2].min(), vertices[:, 2].max()
    return Prism(np.array(hull.exterior.coords)[:-1], float(low), float(high), vertices)


def asset_prisms(folder: Path) -> list[Prism]:
    """Prisms of all collision shapes of an asset, in the asset frame."""
    pieces = (prism_of(np.asarray(mesh.vertices, dtype=float)) for mesh in collision_pieces(folder))
    return [prism for prism in pieces if prism is not None]


def placed_prisms(prisms: list[Prism], item: Placed) -> list[Prism]:
    """The prisms of an asset (asset frame) where the item stands (floor frame)."""
    middle = (np.asarray(item.asset.box_min) + np.asarray(item.asset.box_max)) / 2
    turn = yaw_matrix(item.box.yaw)
    rise = item.center[2] - middle[2]
    return [
        Prism(
            (prism.outline - middle[:2]) @ turn[:2, :2].T + item.center[:2],
            prism.low + rise,
            prism.high + rise,
            (prism.vertices - middle) @ turn.T + item.center,
        )
        for prism in prisms
    ]


class Surface(NamedTuple):
    """What something stands on: its height, and its outline from above."""

    height: float
    area: BaseGeometry  # within the hull of what is highest: a raised rim carries what is inside it


def polygons(geometry: BaseGeometry) -> MultiPolygon:
    """Its polygons: what is thinner than the grid is lines there."""
    return MultiPolygon([part for part in shapely.get_parts(geometry) if isinstance(part, Polygon)])


def joined(areas: list[BaseGeometry]) -> MultiPolygon:
    """The union of areas."""
    return polygons(shapely.union_all(areas, GRID))


def without(area: BaseGeometry, other: BaseGeometry) -> MultiPolygon:
    """An area less another."""
    return polygons(area.difference(other, GRID))


def surface_beneath(item: Placed, lower: Placed, support: list[Prism]) -> Surface:
    """The surface that carries an item: the seat of a chair, not its back.

    Of the surfaces seen from above that are wide enough, the one that most of the item is over, else the nearest one.
    If no piece is wide enough, the top of the box.

    Args:
        lower: what carries it; `support` are its pieces.
    """
    under, taller = footprint(item.box), Polygon()
    whole = MultiPoint(np.concatenate([prism.outline for prism in support])).convex_hull if support else taller
    reach = HOLDS * min(shorter_side(under), shorter_side(whole)) / 2
    found: dict[tuple[float, float, float], BaseGeometry] = {}
    left = sorted(support, key=lambda prism: prism.high)
    while left:
        height = left[-1].high
        pieces = [prism for prism in left if prism.high > height - LEVEL]
        left = left[: -len(pieces)]
        level = joined([Polygon(piece.outline) for piece in pieces])
        highest = joined([Polygon(piece.outline) for piece in pieces if piece.high > height - EVEN])
        surface, carries, taller = without(level, taller), without(highest, taller), joined([taller, level])
        if not surface.buffer(-reach).is_empty:
            area = surface if carries.is_empty else polygons(surface.intersection(carries.convex_hull, GRID))
            found[surface.intersection(under).area, -surface.distance(under), height] = area
    if not found:
        return Surface(lower.top, footprint(lower.box))
    return Surface(max(found)[2], balanced(item, lower, support, found[max(found)]))


def balanced(item: Placed, lower: Placed, support: list[Prism], surface: BaseGeometry) -> BaseGeometry:
    """The part of a surface where an item does not tip over what carries it: both weigh over the lower one's feet.

    All of it if there is no such part, or the lower one is held.
    """
    if lower.held:
        return surface
    lowest = min(prism.low for prism in support)
    feet = MultiPoint(np.concatenate([prism.outline for prism in support if prism.low < lowest + LEVEL])).convex_hull
    reach = 1 + lower.asset.mass / item.asset.mass
    steady = affinity.scale(feet.buffer(-STEADY * shorter_side(feet)), reach, reach, origin=tuple(lower.center[:2]))
    within = surface.intersection(steady)
    return surface if steady.contains(surface) or within.area == 0 else within


def steady_region(item: Placed, surface: BaseGeometry) -> BaseGeometry:
    """Where the centre of an item may be that stands on a surface: over it, and not just above its edge."""
    inset = surface.buffer(-STEADY * min(shorter_side(footprint(item.box)), shorter_side(surface.convex_hull)))
    return surface if inset.is_empty else inset


def shorter_side(area: BaseGeometry) -> float:
    """Of the smallest rectangle, turned as may be, around an area."""
    if not isinstance(area, Polygon) or area.is_empty:
        return 0.0
    corner = np.array(area.minimum_rotated_rectangle.exterior.coords)
    return float(np.linalg.norm(np.diff(corner[:3], axis=0), axis=1).min())


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
