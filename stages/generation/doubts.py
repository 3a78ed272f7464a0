"""What of a placed object should not be taken for certain: its size, its place, what holds it."""

from stages.contracts.objects import SceneObject, Wall
from stages.generation.placed import UNNAMED, Placed
from stages.generation.walls import CONTACT, behind, is_beyond
from stages.procedural.naming import category_in
from stages.procedural.sizes import unusual

MOST = 0.5  # of an object's pixels: with less of them known in depth, what is known may be of something else


def doubts(item: Placed, walls: list[Wall], seen: SceneObject) -> list[str]:
    """In words; none: nothing is odd. Sizes that a person says are not doubted.

    Args:
        seen: the object as extraction found it.
    """
    found = []
    if "size" not in seen.told and (what := unusual(category_in(item.label), item.size)):
        found.append(what)
    if seen.depth_known is not None and seen.depth_known < MOST:
        found.append(f"depth is known on {100 * seen.depth_known:.0f} % of its pixels: its place is not certain")
    for wall in walls:
        if is_beyond(item.box, wall):
            found.append(f"is seen beyond {wall.id}: past its end or through an opening, else in a mirror")
        elif (depth := behind(item.box, wall)) > CONTACT:
            found.append(f"reaches {100 * depth:.0f} cm behind {wall.id}")
    if item.support == UNNAMED:
        found.append("stands on something that was not named, and is held there: name what carries it")
    return found
