"""Support surfaces: that of a thing which carries another, and where on it the other stands firmly."""

from typing import NamedTuple

import numpy as np
import shapely
from shapely import MultiPoint, MultiPolygon, Polygon, affinity
from shapely.geometry.base import BaseGeometry

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.generation.placed import Placed, Prism
from roomkin.stages.geometry.boxes import THINNEST, footprint

HOLDS = 0.5  # of half the width of what it is to carry: a narrower surface (a back, a rail) carries nothing; chosen
OVERLAY_GRID = 1e-6  # metres to which outlines are cut and joined: overlays of floating point numbers may fail
STEADY = 0.1  # of the width of what stands near an edge: the least distance of its center from that edge; chosen


class SupportSurface(NamedTuple):
    """A support surface: its height, and its outline from above."""

    height: float
    area: BaseGeometry  # within the hull of what is highest: a raised rim carries what is inside it

    def steady_region(self, item: Placed) -> BaseGeometry:
        """The region for the center of an item that stands on it: over it, and not just above its edge."""
        side = min(measure_shorter_side(footprint(item.box)), measure_shorter_side(self.area.convex_hull))
        inset = self.area.buffer(-STEADY * side)
        return self.area if inset.is_empty else inset


def find_surface(item: Placed, lower: Placed) -> SupportSurface:
    """The surface of `lower` that carries an item: the seat of a chair, not its back.

    Of the surfaces seen from above that are wide enough, the one that most of the item is over, else the nearest one.
    If no piece is wide enough, the top of the box.
    """
    pieces, under, taller = lower.collision_prisms, footprint(item.box), Polygon()
    whole = MultiPoint(np.concatenate([piece.outline for piece in pieces])).convex_hull if pieces else taller
    reach = HOLDS * min(measure_shorter_side(under), measure_shorter_side(whole)) / 2
    found: dict[tuple[float, float, float], BaseGeometry] = {}
    left = sorted(pieces, key=lambda piece: piece.high)
    while left:
        height = left[-1].high
        topmost = [piece for piece in left if piece.high > height - THINNEST]
        left = left[: -len(topmost)]
        level = join([Polygon(piece.outline) for piece in topmost])
        highest = join([Polygon(piece.outline) for piece in topmost if piece.high > height - GenerationConfig.touch])
        surface, carries, taller = subtract(level, taller), subtract(highest, taller), join([taller, level])
        if not surface.buffer(-reach).is_empty:
            within = surface.intersection(carries.convex_hull, OVERLAY_GRID)
            area = surface if carries.is_empty else keep_polygons(within)
            found[surface.intersection(under).area, -surface.distance(under), height] = area
    if not found:
        return SupportSurface(lower.top, footprint(lower.box))
    return SupportSurface(max(found)[2], keep_balanced(item, lower, pieces, found[max(found)]))


def measure_shorter_side(area: BaseGeometry) -> float:
    """Of the smallest rectangle, turned as may be, around an area."""
    if not isinstance(area, Polygon) or area.is_empty:
        return 0.0
    corner = np.array(area.minimum_rotated_rectangle.exterior.coords)
    return float(np.linalg.norm(np.diff(corner[:3], axis=0), axis=1).min())


def join(areas: list[BaseGeometry]) -> MultiPolygon:
    """The union of areas."""
    return keep_polygons(shapely.union_all(areas, OVERLAY_GRID))


def subtract(area: BaseGeometry, other: BaseGeometry) -> MultiPolygon:
    """An area less another."""
    return keep_polygons(area.difference(other, OVERLAY_GRID))


def keep_polygons(geometry: BaseGeometry) -> MultiPolygon:
    """Its polygons: what is thinner than the grid is lines there."""
    return MultiPolygon([part for part in shapely.get_parts(geometry) if isinstance(part, Polygon)])


def keep_balanced(item: Placed, lower: Placed, pieces: list[Prism], surface: BaseGeometry) -> BaseGeometry:
    """The part of a surface where an item does not tip its support over: their common center of mass is above its
    feet.

    All of it if there is no such part, or the support cannot fall.
    """
    if lower.held:
        return surface
    lowest = min(piece.low for piece in pieces)
    feet = MultiPoint(np.concatenate([piece.outline for piece in pieces if piece.low < lowest + THINNEST])).convex_hull
    reach = 1 + lower.asset.mass / item.asset.mass
    inset = feet.buffer(-STEADY * measure_shorter_side(feet))
    steady = affinity.scale(inset, reach, reach, origin=tuple(lower.center[:2]))
    within = surface.intersection(steady)
    return surface if steady.contains(surface) or within.area == 0 else within
