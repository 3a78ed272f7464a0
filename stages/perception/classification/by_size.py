"""The names of outlines of a picture without depth: by looks, and by how large where they stand, rest or hang makes
them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.perception.camera.metrology import UprightPlane
from roomkin.stages.perception.classification.names import ODD, Names, carries
from roomkin.stages.perception.classification.naming import FLAT_CATEGORIES
from roomkin.stages.perception.classification.propose import read_coco
from roomkin.stages.perception.layout import things as kinds
from roomkin.stages.perception.layout.ends import FLOOR as ON_FLOOR
from roomkin.stages.perception.layout.ends import LEGGED, Ends, Kind, Mask, find_beneath, list_alone, usual_of
from roomkin.stages.perception.layout.fit import FitItem, choose_modes
from roomkin.stages.perception.layout.room import Arrangement, FittedRoom
from roomkin.stages.perception.layout.things import OutlineCandidate
from roomkin.stages.perception.layout.walls import NORMALS, measure_rectangle

Array = NDArray[np.float64]
LOW = -0.15  # slope of a ray to the floor: what is farther is too far for a room; chosen
MISSED = 0.3  # how likely COCO's network misses a thing that it knows; chosen
MEANT = 0.2  # share of what a class of COCO is said of, from which on it means a category; chosen
LIKELY = 0.1  # least probability of a name that size may choose; chosen
LEAST = 0.003  # share of the picture that what stands on the floor without a known class covers at least; chosen
USUAL_FAR = 3.0  # metres to a wall before which nothing is known; chosen
SELDOM = 0.02  # how likely what hangs is of a category that is not flat, before it is seen; chosen
NOISE = 0.3  # of the logarithms of a width and a height that are measured before the fit; chosen
FAR = 0.6  # of the logarithm of the distance to a wall, before what hangs there has told it; chosen


def name_standing(
    seen: Sequence[OutlineCandidate],
    masks: NDArray[np.integer],
    feet: Mapping[int, Ends],
    arranged: Arrangement,
    labels: Mapping[int, str],
    inside: Mask,
) -> tuple[dict[int, Names], set[int]]:
    """Names of what stands on the floor, of known things by their size too; and what must carry one: that stands.

    Args:
        seen: all outlines; masks (H, W): the value of each is its place, from 1; feet: their ends.
        arranged: those that have `labels`.
        inside: (H, W) pixels that show something: no frame around the picture.
    """
    things = [value for value in feet if seen[value - 1].kind not in (kinds.WALL, kinds.FLOOR)]  # these hide nothing
    items = list_alone(masks, things, inside)
    floor = {0} | {value for value, one in enumerate(seen, 1) if one.kind == kinds.FLOOR}
    beneath = {feet[value].met[3] for value in labels if arranged.kinds[value].places == ("top",)}
    found, view, standing = dict[int, Names](), arranged.view, list_names("floor")
    for value, item in items.items():
        one, carries_one = seen[value - 1], value in beneath
        known = arranged.on.get(value) == ON_FLOOR
        likely = [each for each in one.names.proposals if each.probability > LIKELY] or one.names.proposals[:1]
        if known:
            kept = [each.category for each in likely]
        elif value not in labels and (carries_one or one.kind == kinds.STANDS) and one.mask.mean() >= LEAST:
            kept = standing if feet[value].met[3] in floor else [name for name in standing if name != "rug"]
            kept = [name for name in kept if carries(name)] if carries_one else kept
        else:
            continue
        try:
            if known or view.rays(find_foot(item.ends))[2] <= LOW:
                sizes = weigh_sizes(arranged, item, kept)
                alike = dict.fromkeys(kept, 1.0)
                names = Names(likely, one.names.other) if known else one.names.choose_among(alike, expect_found())
                found[value] = names.weigh(sizes) if known else names.weigh(sizes).doubt(one.names.other)
        except ODD:  # it has no place that a thing of any name could have
            continue
    return found, beneath & found.keys()


def name_others(
    seen: Sequence[OutlineCandidate],
    masks: NDArray[np.integer],
    feet: Mapping[int, Ends],
    room: FittedRoom,
    placed: Mapping[int, Kind],
) -> dict[int, Names]:
    """Names of what hangs on a wall and of what rests on a thing that has a place. Arguments as of `name_standing`.

    placed: what each thing is that has a name.
    """
    carriers = [value for value in room.boxes if placed[value].carries]
    found = dict[int, Names]()
    for value, one in enumerate(seen, 1):
        if value in placed or value not in feet:
            continue
        beneath = find_beneath(masks, value, feet[value], carriers)
        kind = one.kind if beneath else one.choose_kind(without=kinds.RESTS)
        try:
            if kind == kinds.HANGS:
                size, far = measure_hung(room, one), FAR
                before = {name: FLAT_CATEGORIES.get(name, SELDOM) for name in list_names("wall")}
            elif kind == kinds.RESTS:
                size, far = measure_resting(room, feet[value], beneath), NOISE
                before = dict.fromkeys(list_names("top"), 1.0)
            else:
                continue
            if size is not None:
                named = name_by_extents(size, far, one, before)
                found[value] = named if kind == kinds.HANGS else named.doubt(one.names.other)
        except ODD:  # as above
            continue
    return found


def find_foot(ends: Ends) -> Array:
    """The pixel (2,) below the middle of an outline, where it ends."""
    left, _, right, bottom = ends.at * [-1, 1, 1, 1]
    return np.array([(left + right) / 2, bottom])


def measure_hung(room: FittedRoom, one: OutlineCandidate) -> Array | None:
    """Width and height (2,) of an outline on the wall that it lies on best, metres; None: it faces none."""
    farthest = max((float(box.center[1]) for box in room.boxes.values()), default=USUAL_FAR)
    walls = room.walls or [UprightPlane(NORMALS[0], -farthest)]
    share, sides = max((measure_rectangle(room.view, wall, one.mask) for wall in walls), key=lambda each: each[0])
    return np.ptp(sides, axis=0) if share > 0 else None


def measure_resting(room: FittedRoom, ends: Ends, beneath: int) -> Array | None:
    """Width and height (2,) of an outline that rests on a thing, metres; None: it would rest above the horizon."""
    box, view = room.boxes[beneath], room.view
    foot = view.rays(find_foot(ends))
    down = view.above - float(box.center[2] + box.size[2] / 2)
    if down * foot[2] >= 0:
        return None
    left, top, right, bottom = ends.at
    return np.array([left + right, top + bottom]) * -down / foot[2] / view.focal


def list_names(place: str) -> list[str]:
    """The categories whose things may be in a place: floor, top or wall."""
    return [name for name, category in known_categories().items() if place in category.places]


def weigh_sizes(arranged: Arrangement, item: FitItem, names: Sequence[str]) -> dict[str, float]:
    """How likely a thing is where it is seen, if it is one of these categories, against the likeliest."""
    usual = [usual_of(known_categories()[name]) for name in names]
    each = [replace(item, usual=one, legs=name in LEGGED) for name, one in zip(names, usual, strict=True)]
    alone = [choose_modes(arranged.camera, [one], arranged.state)[1][0] for one in each]
    spreads = [np.linalg.slogdet(one.usual.covariance)[1] / 2 for one in each]
    costs = [float(cost + spread) for cost, spread in zip(alone, spreads, strict=True)]
    return {name: float(np.exp(min(costs) - cost)) for name, cost in zip(names, costs, strict=True)}


def name_by_extents(size: Array, far: float, one: OutlineCandidate, before: Mapping[str, float]) -> Names:
    """Names of what is so wide and high (2,), metres, by its looks and by how usual that is.

    far: deviation of the logarithm of its distance.
    """
    misfits = dict[str, float]()
    for name in before:
        usual = usual_of(known_categories()[name])
        covariance = usual.covariance[np.ix_([0, 2], [0, 2])] + NOISE**2 * np.eye(2) + far**2
        off = np.log(np.maximum(size, 1e-3)) - usual.mean[[0, 2]]
        misfits[name] = float(off @ np.linalg.solve(covariance, off) + np.linalg.slogdet(covariance)[1])
    least = min(misfits.values())
    sizes = {name: float(np.exp((least - off) / 2)) for name, off in misfits.items()}
    return one.names.choose_among(before, expect_found()).weigh(sizes)


@cache
def expect_found() -> dict[str, float]:
    """How likely a thing of a category was not found by COCO's network: of those that its classes often mean."""
    return {name: MISSED for shares in read_coco().values() for name, share in shares.items() if share >= MEANT}
