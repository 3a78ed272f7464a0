"""What of a placed object may be wrong: its size, its place, what holds it. The kinds of doubts: `contracts.doubt`."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stages.contracts import doubt as kinds
from stages.contracts.category import Category, describe_unusual, find_category
from stages.contracts.doubt import Doubt
from stages.contracts.objects import SceneObject, Wall
from stages.generation.inputs import Inputs
from stages.generation.placed import UNNAMED, Placed
from stages.geometry.boxes import depth_behind, is_behind

UNUSUAL = float(np.log(kinds.UNUSUAL_SIZE.threshold))


def doubt_placements(items: list[Placed], inputs: Inputs) -> list[Placed]:
    """The items, each with what may be wrong with it."""
    room, seen = inputs.objects, {item.id: item for item in inputs.objects.objects}
    return [doubt_placement(item, room.walls, seen[item.id], inputs.categories) for item in items]


def doubt_placement(item: Placed, walls: list[Wall], seen: SceneObject, known: Mapping[str, Category]) -> Placed:
    """The item with what may be wrong with it. Sizes that a person says are not doubted.

    Args:
        seen: the object as extraction found it.
        known: categories by name, as the library knows them.
    """
    found: list[Doubt] = []
    if item.support == UNNAMED:
        found.append(kinds.UNNAMED.of())
    for wall in walls:
        if is_behind(item.box, wall.normal, wall.offset):
            found.append(kinds.BEYOND_WALL.of(wall=wall.id))
        elif (depth := depth_behind(item.box, wall.normal, wall.offset)) > kinds.BEHIND_WALL.threshold:
            found.append(kinds.BEHIND_WALL.of(depth=100 * depth, wall=wall.id))
    if seen.depth_known is not None and seen.depth_known < kinds.DEPTH_UNKNOWN.threshold:
        found.append(kinds.DEPTH_UNKNOWN.of(share=100 * seen.depth_known))
    odd = describe_unusual(find_category(item.label, known), item.size, UNUSUAL)
    if odd and "size" not in seen.told:
        found.append(kinds.UNUSUAL_SIZE.of(what=odd))
    return replace(item, doubts=(*item.doubts, *found))
