"""What stands on what, and what hangs, by masks and by where things of a category are."""

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.eyes.naming import CARRIERS
from plugins.single_view.ends import Ends
from stages.contracts.categories import known_categories
from stages.contracts.category import Category, find_category

FLOOR, WALL, NOWHERE = 0, -1, -2  # in the place of the mask of what carries a thing
LEGGED = {"bench", "chair", "coffee_table", "desk", "floor_lamp", "stool", "table"}  # whose masks leave thin legs out


def category_of(label: str) -> Category | None:
    """The category that a label means."""
    return find_category(label, known_categories())


def find_supports(masks: NDArray[np.integer], labels: Mapping[int, str], ends: Mapping[int, Ends]) -> dict[int, int]:
    """What carries each thing: the value of another's mask, `FLOOR`, `WALL`, or `NOWHERE`: it is
    not seen.

    Args:
        masks: (H, W).
        labels: of the things, by the values of their masks.
        ends: likewise.
    """
    known = {value: category_of(label) for value, label in labels.items()}
    carriers = [value for value, one in known.items() if one is None or CARRIERS & set(one.kin)]
    on = dict.fromkeys(labels, FLOOR)
    for value, category in known.items():
        places = category.places if category else ["floor", "top"]
        if "top" in places:
            beneath = find_beneath(masks, value, ends[value], [one for one in carriers if one != value])
            if beneath and not stands_on(beneath, value, on):
                on[value] = beneath
                continue
            if places == ["top"]:
                on[value] = NOWHERE
                continue
        if places[0] == "wall" or ("wall" in places and "floor" not in places):
            on[value] = WALL
    return on


def stands_on(value: int, other: int, on: Mapping[int, int]) -> bool:
    """Whether a thing stands on another, directly or not."""
    while value > 0:
        if value == other:
            return True
        value = on[value]
    return False


def find_beneath(masks: NDArray[np.integer], value: int, ends: Ends, carriers: list[int]) -> int:
    """The carrier below a mask's lower end, or around it; 0: none."""
    if ends.met[3] in carriers:
        return ends.met[3]
    rows, columns = np.nonzero(masks == value)
    low = rows >= rows.max() - 2
    foot = float(np.median(columns[low])), float(rows.max())
    found = []
    for other in carriers:
        pixels = np.column_stack(np.nonzero(masks == other)[::-1]).astype(np.int32)
        if cv2.pointPolygonTest(cv2.convexHull(pixels), foot, False) >= 0:
            found.append((len(pixels), other))
    return min(found)[1] if found else 0


def find_open(value: int, ends: Mapping[int, Ends], on: Mapping[int, int]) -> NDArray[np.bool_]:
    """Which ends (4,) of a thing are those of the picture or of what is before it: it may go on unseen there.

    Of two things side by side that with the lower foot is nearer. What carries a thing, or stands on it, hides at most
    its lower end.
    """
    own = ends[value]
    found = own.cut.copy()
    for side, other in enumerate(own.met):
        if not other or on[value] == other:
            continue
        if on[other] == value:
            found[side] |= side == 3
        elif side == 3 or ends[other].cut[3] or ends[other].at[3] > own.at[3] + 2:
            found[side] = True
    return found
