"""What of a placed object should not be taken for certain: its size, its place, what holds it."""

from stages.contracts.objects import Wall
from stages.generation.placed import UNNAMED, Placed
from stages.generation.walls import CONTACT, behind
from stages.procedural.naming import category_in
from stages.procedural.sizes import unusual


def doubts(item: Placed, walls: list[Wall], sized: bool = False) -> list[str]:
    """In words; none: nothing is odd.

    Args:
        sized: a person says how large it is, however unusual that is.
    """
    found = []
    if not sized and (what := unusual(category_in(item.label), item.size)):
        found.append(what)
    for wall in walls:
        if (depth := behind(item.box, wall)) > CONTACT:
            found.append(f"reaches {100 * depth:.0f} cm behind {wall.id}")
    if item.support == UNNAMED:
        found.append("stands on something that was not named, and is held there: name what carries it")
    return found
