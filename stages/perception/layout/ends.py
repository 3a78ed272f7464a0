"""Where masks end in a picture without depth, and what carries what: by masks and by where things of a category are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import CategoryFacts, SizeSpread, find_category
from roomkin.stages.perception.classification.names import CARRIERS

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
FLOOR, WALL, NOWHERE = 0, -1, -2  # in the place of the mask of what carries a thing
UNKNOWN = SizeSpread(np.log([0.5, 0.5, 0.6]), 0.7**2 * np.eye(3))  # of a thing that has no name; chosen
LEGGED = {"bench", "chair", "coffee_table", "desk", "floor_lamp", "stool", "table"}  # whose masks leave thin legs out
STEPS = np.array([(-1, 0), (0, -1), (1, 0), (0, 1)])  # out of the mask, x and y
BAND = 0.05  # of a mask's extent: its pixels nearest to an end; chosen
BEYOND = 0.01  # of the picture's longer side, from an end to what is next to it: masks leave gaps; chosen
MOST = 0.5  # share of an end next to which something is, from which on it is so; chosen


@dataclass(frozen=True)
class Ends:
    """The ends of a mask to the left, top, right and bottom.

    Attributes:
        at: (4,) pixels, signed along `STEPS`: -x0, -y0, x1, y1.
        cut: (4,) whether the picture's border ends it.
        met: of each side, the thing that it ends at; 0: none.
        limit: (4,) where that thing ends, along the same direction.
    """

    at: Array
    cut: Mask
    met: tuple[int, int, int, int]
    limit: Array


def number_masks(masks: Mapping[int, Mask], shape: tuple[int, ...]) -> NDArray[np.uint16]:
    """One picture (H, W) of masks, with the value of each."""
    values = np.zeros(shape, np.uint16)
    for value, mask in masks.items():
        values[mask] = value
    return values


def measure_ends(masks: NDArray[np.integer], value: int, inside: Mask) -> Ends:
    """The ends of one of the masks (H, W). `inside`: (H, W) pixels that show something: no frame around the picture."""
    height, width = masks.shape
    rows, columns = np.nonzero(masks == value)
    pixels = np.column_stack([columns, rows])
    at, cut, met, limit = np.zeros(4), np.zeros(4, bool), [], np.zeros(4)
    for side, step in enumerate(STEPS):
        rim = find_rim(pixels, step)
        along = rim @ step
        at[side] = limit[side] = along.max() + 0.5
        last = rim[along >= along.max() - max(2.0, BAND * np.ptp(pixels @ step))]
        x, y = (last + max(5, round(BEYOND * max(masks.shape))) * step).T
        there = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = np.where(there, x, 0), np.where(there, y, 0)
        there &= inside[y, x]
        other = np.where(there & (masks[y, x] != value), masks[y, x], 0)
        cut[side] = (~there).mean() > MOST
        counts = np.bincount(other)
        counts[0] = 0
        found = int(counts.argmax()) if counts.max() > MOST * len(last) else 0
        met.append(found)
        if found:
            shown = np.column_stack(np.nonzero(masks == found)[::-1])
            limit[side] = max(at[side], float((shown @ step).max()) + 0.5)
    return Ends(at, cut, (met[0], met[1], met[2], met[3]), limit)


def find_rim(pixels: NDArray[np.integer], step: NDArray[np.integer]) -> NDArray[np.integer]:
    """Of the pixels (N, 2) the last along `step` in each row or column."""
    across = pixels @ np.abs(step[::-1])
    order = np.lexsort((pixels @ step, across))
    last = np.append(np.diff(across[order]) != 0, True)
    return pixels[order[last]]


def measure_all(masks: NDArray[np.integer], values: Sequence[int], inside: Mask) -> Mapping[int, Ends]:
    """The ends of those masks (H, W) that have these values; the rest hide nothing."""
    things = np.where(np.isin(masks, values), masks, 0)
    return {value: measure_ends(things, value, inside) for value in values}


@dataclass(frozen=True)
class FitItem:
    """A thing to be fitted.

    Attributes:
        open: which of its ends (4,) may go on unseen, as far as `Ends.limit`, at the picture's border without limit.
        usual: of its width, depth and height.
        on: the number of the thing that it stands on; -1: the floor.
        legs: whether an outline may lack its legs. across: whether it may stand across the room.
        yaw: of its width, from the room's x axis, radians.
        endless: whether its foot may lie anywhere below its outline.
        penalty: cost of all this.
        ground: height of what it stands on, metres, if that is no thing of the fit.
    """

    ends: Ends
    open: NDArray[np.bool_]
    usual: SizeSpread
    on: int = -1
    legs: bool = False
    across: bool = False
    yaw: float = 0.0
    endless: bool = False
    penalty: float = 0.0
    ground: float = 0.0


@dataclass(frozen=True)
class Kind:
    """What a thing is: kinds of things that it is one of, where those are, how large and deep they usually are, whether
    they carry others, and whether outlines may lack their legs."""

    kin: frozenset[str]
    places: tuple[str, ...]
    usual: SizeSpread
    depth: float | None
    carries: bool
    legs: bool


@cache
def kind_of(label: str) -> Kind:
    """What things of a label are; of no category: anything that stands or rests on others."""
    category = find_category(label, known_categories())
    if category is None:
        return Kind(frozenset(), ("floor", "top"), UNKNOWN, None, carries=True, legs=True)
    kin, legs = frozenset(category.kin), category.name in LEGGED
    depth, carries = category.find_usual_depth(), bool(CARRIERS & kin)
    return Kind(kin, tuple(category.places), usual_of(category), depth, carries, legs)


def usual_of(category: CategoryFacts | None) -> SizeSpread:
    """The usual width, depth and height of a category."""
    spread = category.measure_spread() if category else None
    return spread.turn() if spread else UNKNOWN


def find_supports(masks: NDArray[np.integer], known: Mapping[int, Kind], ends: Mapping[int, Ends]) -> dict[int, int]:
    """What carries each thing: the value of another's mask, `FLOOR`, `WALL`, or `NOWHERE`: it is
    not seen.

    Args:
        masks: (H, W).
        known: what the things are, by the values of their masks.
        ends: likewise.
    """
    carriers = [value for value, one in known.items() if one.carries]
    on = dict.fromkeys(known, FLOOR)
    for value, one in known.items():
        places = one.places
        if "top" in places:
            beneath = find_beneath(masks, value, ends[value], [one for one in carriers if one != value])
            if beneath and not stands_on(beneath, value, on):
                on[value] = beneath
                continue
            if places == ("top",):
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


def list_items(
    masks: NDArray[np.integer], labels: Mapping[int, str], inside: Mask
) -> tuple[dict[int, FitItem], dict[int, int], dict[int, Kind]]:
    """The things of masks (H, W); where nothing stands that only the floor carries, a table top may be the ground.

    Args:
        labels: of the things, by the values of their masks.
        inside: (H, W) pixels that show something: no frame around the picture.
    """
    kinds = {value: kind_of(label) for value, label in labels.items()}
    ends = measure_all(masks, list(labels), inside)
    on = find_supports(masks, kinds, ends)
    if all(holder in (WALL, NOWHERE) or "top" in kinds[value].places for value, holder in on.items()):
        on = {value: FLOOR if holder == NOWHERE else holder for value, holder in on.items()}
    standing = [value for value in labels if on[value] not in (WALL, NOWHERE)]
    number, items = {value: number for number, value in enumerate(standing)}, {}
    for value in standing:
        kind, hidden = kinds[value], find_open(value, ends, on)
        carrier, across = number.get(on[value], -1), "seat" in kind.kin
        items[value] = FitItem(ends[value], hidden, kind.usual, carrier, legs=kind.legs, across=across)
    return items, on, kinds


def list_alone(masks: NDArray[np.integer], values: Sequence[int], inside: Mask) -> dict[int, FitItem]:
    """Those of the masks (H, W) that have these values, each as if it stood on the floor and were anything."""
    ends = measure_all(masks, values, inside)
    on = dict.fromkeys(ends, FLOOR)
    return {value: FitItem(own, find_open(value, ends, on), UNKNOWN) for value, own in ends.items()}
