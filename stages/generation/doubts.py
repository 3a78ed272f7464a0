"""What of a placed object may be wrong: its size, its place, what holds it."""

from collections.abc import Mapping

import numpy as np

from stages.contracts.category import Category, describe_unusual, find_category
from stages.contracts.doubt import Doubt
from stages.contracts.objects import SceneObject, Wall
from stages.generation.placed import UNNAMED, Placed
from stages.generation.walls import CONTACT, behind, is_beyond

MOST = 0.5  # of an object's pixels: with less of them known in depth, what is known may be of something else
# An extent so far beyond those of its category was wrong in three of four cases (docs/results/open.md, half `work`).
BEYOND = float(np.log(1.25))


def doubts(item: Placed, walls: list[Wall], seen: SceneObject, known: Mapping[str, Category]) -> list[Doubt]:
    """None: nothing is odd. Sizes that a person says are not doubted.

    Args:
        seen: the object as extraction found it.
        known: categories by name, as the library knows them.
    """
    place = []
    if item.support == UNNAMED:
        place.append("stands on something that was not named, and is held there")
    for wall in walls:
        if is_beyond(item.box, wall):
            place.append(f"is seen beyond {wall.id}: past its end or through an opening, else in a mirror")
        elif (depth := behind(item.box, wall)) > CONTACT:
            place.append(f"reaches {100 * depth:.0f} cm behind {wall.id}")
    if seen.depth_known is not None and seen.depth_known < MOST:
        place.append(f"depth is known on {100 * seen.depth_known:.0f} % of its pixels: its place is not certain")
    found = [Doubt(cause="place", what=what) for what in place]
    odd = describe_unusual(find_category(item.label, known), item.size, BEYOND)
    if odd and "size" not in seen.told:
        found.append(Doubt(cause="size", what=odd))
    return found
