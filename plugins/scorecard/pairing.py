"""Which submitted thing stands for which true one: by number where masks were given, else by where it stands."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from roomkin.plugins.scorecard.truth import TrueThing
from roomkin.stages.geometry.boxes import UprightBox

NEAR, LEAST = 0.5, 0.15  # of the true box's diagonal, metres: centers farther apart are of two things; chosen
ALIKE = 3.0  # times the true box's diagonal, or a part of it: what is larger or smaller is another thing; chosen


def pair_things(
    asked: Sequence[TrueThing], boxes: Sequence[UprightBox], numbers: Sequence[int | None]
) -> Mapping[int, int]:
    """The place of the submitted thing of each true one, by number; one for one, the nearest over all.

    Names play no part: a thing with a wrong name is placed, and not sensible.

    Args:
        asked: true things.
        boxes: submitted ones, in the world.
        numbers: mask value of each; None: by its place alone.
    """
    told = {number: place for place, number in enumerate(numbers) if number is not None}
    found = {thing.number: told[thing.number] for thing in asked if thing.number in told}
    left = [thing for thing in asked if thing.number not in found]
    free = [place for place, number in enumerate(numbers) if number is None]
    if not left or not free:
        return found
    diagonals = np.array([np.linalg.norm(thing.size) for thing in left])
    gate = np.maximum(LEAST, NEAR * diagonals)
    centers = np.array([boxes[place].center for place in free])
    apart = np.linalg.norm(np.array([thing.position for thing in left])[:, None] - centers, axis=2)
    sizes = np.array([np.linalg.norm(boxes[place].size) for place in free])
    ratio = np.log(sizes / diagonals[:, None])
    gain = np.where(np.abs(ratio) <= np.log(ALIKE), np.clip(1 - apart / gate[:, None], 0, None), 0)
    rows, columns = linear_sum_assignment(gain, maximize=True)
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return found | {left[row].number: free[column] for row, column in pairs if gain[row, column] > 0}
