"""What of a placed object should not be taken for certain: its size, its place, what holds it."""

import numpy as np

from stages.contracts.objects import Wall
from stages.generation.placed import UNNAMED, Placed
from stages.geometry.boxes import corners
from stages.procedural.naming import category_in
from stages.procedural.sizes import unusual

BEHIND = 0.05  # metres


def reach_behind(item: Placed, wall: Wall) -> float:
    """How far an object's box reaches behind a wall, metres; negative: it is before it."""
    return wall.offset - float((corners(item.box) @ np.asarray(wall.normal)).min())


def doubts(item: Placed, walls: list[Wall], sized: bool = False) -> list[str]:
    """In words; none: nothing is odd.

    Args:
        sized: a person says how large it is, however unusual that is.
    """
    found = []
    if not sized and (what := unusual(category_in(item.label), item.size)):
        found.append(what)
    for wall in walls:
        if (behind := reach_behind(item, wall)) > BEHIND:
            found.append(f"reaches {100 * behind:.0f} cm behind {wall.id}")
    if item.support == UNNAMED:
        found.append("stands on something that was not named, and is held there: name what carries it")
    return found
