"""Doubts about a placed object: its size, its place, its support. The kinds of doubts: `contracts.doubt`."""

import math
from collections.abc import Mapping
from dataclasses import replace

from roomkin.stages.contracts.category import Category, describe_unusual, find_category
from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.generated import measure_place_sureness, measure_sureness
from roomkin.stages.contracts.objects import SceneObject, Wall
from roomkin.stages.generation.inputs import Inputs
from roomkin.stages.generation.placed import UNNAMED, Placed
from roomkin.stages.geometry.boxes import depth_behind, is_behind


def doubt_placements(items: list[Placed], inputs: Inputs) -> list[Placed]:
    """The items, each with what may be wrong with it."""
    room, seen = inputs.objects, {item.id: item for item in inputs.objects.objects}
    moved = {name for name, nudge in inputs.nudges.items() if nudge is not None}
    return [
        doubt_placement(item, room.walls, seen[item.id], inputs.categories, moved=item.id in moved) for item in items
    ]


def doubt_placement(
    item: Placed, walls: list[Wall], seen: SceneObject, known: Mapping[str, Category], moved: bool = False
) -> Placed:
    """The item with what may be wrong with it. Sizes that a person says are not doubted, nor places.

    Args:
        seen: the object as extraction found it.
        known: categories by name, as the library knows them.
        moved: whether a person moved it.
    """
    found: list[Doubt] = []
    if item.support == UNNAMED:
        found.append(DoubtKind.UNNAMED.of())
    for wall in walls:
        if is_behind(item.box, wall.normal, wall.offset):
            found.append(DoubtKind.BEYOND_WALL.of(wall=wall.id))
        elif (depth := depth_behind(item.box, wall.normal, wall.offset)) > DoubtKind.BEHIND_WALL.threshold:
            found.append(DoubtKind.BEHIND_WALL.of(depth=100 * depth, wall=wall.id))
    if seen.depth_known is not None and seen.depth_known < DoubtKind.DEPTH_UNKNOWN.threshold:
        found.append(DoubtKind.DEPTH_UNKNOWN.of(share=100 * seen.depth_known))
    if "size" not in seen.told:
        limit = math.log(DoubtKind.UNUSUAL_SIZE.threshold)
        if odd := describe_unusual(find_category(item.label, known), item.size, limit):
            found.append(DoubtKind.UNUSUAL_SIZE.of(what=odd))
        if item.spread and (sure := measure_sureness(item.size, item.spread)) < DoubtKind.SIZE_UNSURE.threshold:
            depth, width, height = (100 * math.expm1(each) for each in item.spread)
            found.append(DoubtKind.SIZE_UNSURE.of(share=100 * sure, depth=depth, width=width, height=height))
    if item.place_spread and not moved:
        sure = measure_place_sureness(item.place_spread)
        if sure < DoubtKind.PLACE_UNSURE.threshold:
            found.append(DoubtKind.PLACE_UNSURE.of(share=100 * sure))
    return replace(item, doubts=(*item.doubts, *found))
