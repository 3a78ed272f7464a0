"""The mounting that the input states (paper A.2: by a captioner), with ids of the fitted walls."""

from stages.config.extraction import ExtractionConfig
from stages.contracts.objects import Mounting, Wall
from stages.contracts.scenes import Held
from stages.extraction.walls import gap_to
from stages.geometry.boxes import UprightBox


class ImpossibleError(Exception):
    """The stated mounting is impossible; the one by geometry is used."""


def stated_mounting(
    held: Held, box: UprightBox, walls: list[Wall], fitted: dict[int, str], options: ExtractionConfig
) -> Mounting:
    """The stated mounting with ids of walls.

    Args:
        held: as the input has it.
        box: of what was seen of the object.
        walls: all wall planes.
        fitted: the wall's id by its mask value, of those masks in which a plane was found.
        options: how far the hidden part of an object may reach.

    Raises:
        ImpossibleError: a wall has no plane, or is too far behind the object.
    """
    by_id = {wall.id: wall for wall in walls}
    names = []
    for value in held.walls:
        if value not in fitted:
            raise ImpossibleError(f"no wall is found in mask {value}, at which it is said to be")
        wall = by_id[fitted[value]]
        if (gap := gap_to(box, wall).depth) > options.max_hidden_depth:
            raise ImpossibleError(f"{wall.id}, at which it is said to be, is {gap:.1f} m behind it")
        names.append(wall.id)
    return Mounting(type=held.type, walls=list(dict.fromkeys(names)))
