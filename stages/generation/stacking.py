"""Supports and heights: the 70 % rule (paper A.3), and where on another thing one stands firmly."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from shapely import MultiPoint, MultiPolygon, Point, Polygon, affinity
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts.category import CategoryFacts, find_category, may_stand_on
from roomkin.stages.contracts.types import FLOOR, UNNAMED, WALL
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
        return SupportSurface(lower.box.top, footprint(lower.box))
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


def assign_supports(
    items: list[Placed],
    stated: Mapping[str, str],
    nudges: Mapping[str, Sequence[float] | None],
    options: GenerationConfig,
    categories: Mapping[str, CategoryFacts],
) -> list[Placed]:
    """The items with their supports and at their heights (A.3), from low to high.

    Args:
        stated: by id, what carries it as a person says.
        nudges: by id, metres (x, y) by which a person moves it with all that it carries.
        categories: by name, as the library knows them.
    """
    ordered = sort_by_height(items)
    supports = find_supports(ordered, options.support_overlap, options.stack_tolerance, categories)
    ordered, supports = apply_stated(ordered, supports, stated)
    return nudge(put_on_supports(ordered, supports, options.stack_tolerance is not None), nudges)


def sort_by_height(items: list[Placed]) -> list[Placed]:
    """From low to high by the height of the box center (A.3); ties by id, so that the order is always the same."""
    return sorted(items, key=lambda item: (item.center[2], item.id))


def find_supports(
    items: list[Placed], overlap: float, tolerance: float | None, categories: Mapping[str, CategoryFacts]
) -> dict[str, str]:
    """The support of every item: 'floor', the id of the highest one beneath it, or 'unnamed'.

    What extraction saw beneath it counts: cousins have other sizes than what was seen.

    Args:
        items: sorted from low to high.
        overlap: share of the smaller footprint that must be exceeded (paper: 0.7).
        tolerance: metres by which the upper bottom may lie below the surface. None, as in the paper: a chair tucked
        under a table ends up standing on it. Otherwise an item at the height of a top, over its edge or at most so
        far beside it, stands on that top: noise moves distant items there. An item farther above all that is beneath
        it is 'unnamed' (on a shelf).
        categories: by name; what may not stand on another thing by them does not.
    """
    supports: dict[str, str] = {}
    meant = {item.id: find_category(item.label, categories, like=True) for item in items}
    for index, item in enumerate(items):
        if tolerance is not None and item.support in supports:
            supports[item.id] = item.support
            continue
        beneath = [
            (lower, find_surface(item, lower).height, measure_overlap(item, lower))
            for lower in items[:index]
            if footprint_gap(item, lower) <= (tolerance or 0.0)
            and (tolerance is None or may_stand_on(meant[item.id], meant[lower.id]))
        ]
        carriers = [
            (height, lower.id, lower.box.top)
            for lower, height, shared in beneath
            if shared > overlap and (tolerance is None or item.box.bottom >= height - tolerance)
        ]
        if not carriers and tolerance is not None and item.box.bottom > tolerance and not item.wall_mounted:
            level = [
                (shared, -footprint_gap(item, lower), lower.id, height, lower.box.top)
                for lower, height, shared in beneath
                if abs(item.box.bottom - height) <= tolerance
            ]
            carriers = [(height, name, top) for *_, name, height, top in sorted(level)[-1:]]
        highest = max(carriers, default=(0.0, FLOOR, 0.0))
        top = max((top for *_, top in carriers), default=0.0)  # a stool's may have become a chair's back
        above = tolerance is not None and item.box.bottom > top + tolerance and not item.wall_mounted
        supports[item.id] = UNNAMED if above else highest[1]
    return supports


def measure_overlap(upper: Placed, lower: Placed) -> float:
    """Shared footprint area as a share of the smaller of both footprints."""
    a, b = footprint(upper.box), footprint(lower.box)
    smaller = min(a.area, b.area)
    return float(a.intersection(b).area / smaller) if smaller > 0 else 0.0


def footprint_gap(item: Placed, other: Placed) -> float:
    """Distance of their footprints, metres."""
    return float(footprint(item.box).distance(footprint(other.box)))


def apply_stated(
    ordered: list[Placed], supports: dict[str, str], stated: Mapping[str, str]
) -> tuple[list[Placed], dict[str, str]]:
    """Items and supports with those that a person says; what carries comes before what it carries.

    An item that would carry itself by that stands on the floor, unless its own support was stated too.
    """
    if not stated:
        return ordered, supports
    supports = supports | {name: below for name, below in stated.items() if below in {FLOOR, *supports}}
    for name in stated:
        beneath, seen = supports.get(name, FLOOR), {name}
        while beneath in supports and beneath not in seen:
            seen.add(beneath)
            if supports[beneath] == name:
                supports[beneath] = FLOOR
            beneath = supports[beneath]

    def height(name: str) -> int:
        return 1 + height(supports[name]) if name in supports else 0

    return sorted(ordered, key=lambda item: height(item.id)), supports


def put_on_supports(items: list[Placed], supports: dict[str, str], steady: bool = True) -> list[Placed]:
    """Every item at its height, lower ones first, since a support must be in its place before what it carries.

    A hanging item is only lifted out of what is beneath it. Every other item is put on top of its support.

    Args:
        items: sorted from low to high, so that each comes after its support.
        supports: id -> 'floor', 'unnamed' (it stays at its height) or the id of the item beneath.
        steady: an item over the edge of its support is moved inwards, so that it does not fall.
    """
    done: dict[str, Placed] = {}
    for item in items:
        support, moved, beneath = supports[item.id], item, 0.0
        if support == UNNAMED:
            done[item.id] = replace(item, support=UNNAMED)
            continue
        if support != FLOOR:
            surface = find_surface(item, done[support])
            beneath = surface.height
            if steady and not item.wall_mounted:
                there, here = nearest_points(surface.steady_region(item), Point(item.center[:2]))
                moved = item.shift([there.x - here.x, there.y - here.y, 0.0])
        rise = beneath - item.box.bottom
        moved = moved.shift([0, 0, max(0.0, rise) if item.wall_mounted else rise])
        support = WALL if item.wall_mounted else support
        done[item.id] = replace(item.change_box("on what carries it", moved.box), support=support)
    return list(done.values())


def nudge(items: list[Placed], moves: Mapping[str, Sequence[float] | None]) -> list[Placed]:
    """The items after a person moved some, by id, x and y in metres, each with all that it carries."""
    supports, after = {item.id: item.support for item in items}, {item.id: item for item in items}
    for item in items:
        if move := moves.get(item.id):
            for name in find_stack(item.id, supports):
                after[name] = after[name].shift(np.array([*move, 0.0]))
    return [item.change_box("moved by a person", after[item.id].box) for item in items]


def find_stack(base: str, supports: Mapping[str, str]) -> set[str]:
    """Ids of an item and of everything that it carries, directly or not."""
    stack = {base}
    while True:
        more = {name for name, support in supports.items() if support in stack} - stack
        if not more:
            return stack
        stack |= more
