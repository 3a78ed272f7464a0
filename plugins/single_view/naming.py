"""The names of outlines: by their looks and by how large where they stand, rest or hang makes them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plugins.eyes.naming import FLAT_CATEGORIES
from plugins.inputs.photo.metrology import WallPlane
from plugins.names.propose import read_coco
from plugins.single_view import outline_kinds as kinds
from plugins.single_view.ends import Ends
from plugins.single_view.fit import CameraPrior, Item, Usual
from plugins.single_view.modes import choose_modes
from plugins.single_view.room import NORMALS, Room, usual_of
from plugins.single_view.supports import CARRIERS, LEGGED, category_of, find_beneath, find_open
from plugins.single_view.supports import FLOOR as ON_FLOOR
from plugins.single_view.things import Seen, measure_outlines, number_masks
from plugins.single_view.walls import measure_rectangle
from stages.contracts.categories import known_categories

Array = NDArray[np.float64]
ANYTHING = Usual(np.log([1.0, 0.6, 1.0]), np.diag([1.0, 1.0, 1.0]))  # width, depth, height of what has no name; chosen
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
    rgb: NDArray[np.uint8], seen: Sequence[Seen], room: Room, labels: Mapping[int, str]
) -> dict[int, str]:
    """Labels of what stands on the floor, of known things by their size too; what must carry a known thing stands.

    Args:
        rgb: (H, W, 3).
        seen: all outlines; the value of a mask is its place, from 1.
        room: of those that have `labels`.
    """
    feet = measure_outlines(rgb, [one.mask for one in seen])
    none = np.zeros(rgb.shape[:2], bool)  # walls and the floor hide nothing
    ends = measure_outlines(rgb, [none if one.kind in (kinds.WALL, kinds.FLOOR) else one.mask for one in seen])
    floor = {0} | {value for value, one in enumerate(seen, 1) if one.kind == kinds.FLOOR}
    beneath = {feet[value].met[3] for value in labels if must_be_carried(labels[value])}
    found, camera = dict[int, str](), as_camera(room)
    for value, own in ends.items():
        one = seen[value - 1]
        item = Item(own, find_open(value, ends, dict.fromkeys(ends, ON_FLOOR)), ANYTHING)
        if room.on.get(value) == ON_FLOOR:
            found[value] = rename_by_size(camera, item, one)
        elif value in labels or one.mask.mean() < LEAST or room.view.rays(find_foot(own))[2] > LOW:
            continue
        elif value in beneath or one.kind == kinds.STANDS:
            found[value] = name_by_size(camera, item, one, value in beneath, feet[value].met[3] in floor)
    return found


def name_others(rgb: NDArray[np.uint8], seen: Sequence[Seen], room: Room, labels: Mapping[int, str]) -> dict[int, str]:
    """Labels of what hangs on a wall and of what rests on a thing that has a place. Arguments as of `name_standing`."""
    outlines = [one.mask for one in seen]
    masks, ends = number_masks(rgb, dict(enumerate(outlines, 1))), measure_outlines(rgb, outlines)
    carriers = [value for value in room.boxes if CARRIERS & set(getattr(category_of(labels[value]), "kin", ()))]
    found = dict[int, str]()
    for value, one in enumerate(seen, 1):
        if value in labels:
            continue
        beneath = find_beneath(masks, value, ends[value], carriers)
        kind = one.kind if beneath else one.choose_kind(without=kinds.RESTS)
        if kind == kinds.HANGS:
            size, far = measure_hung(room, one), FAR
            before = {name: FLAT_CATEGORIES.get(name, SELDOM) for name in list_names("wall")}
        elif kind == kinds.RESTS:
            size, far = measure_resting(room, ends[value], beneath), NOISE
            before = dict.fromkeys(list_names("top"), 1.0)
        else:
            continue
        if size is not None:
            found[value] = name_by_extents(size, far, one, before)
    return found


def must_be_carried(label: str) -> bool:
    """Whether things of a label stand on others alone."""
    category = category_of(label)
    return category is not None and category.places == ["top"]


def as_camera(room: Room) -> tuple[CameraPrior, Array]:
    """The camera of a room, as a fit takes it, and as a state."""
    prior = CameraPrior(room.perspective, room.view)
    return prior, np.array([*prior.state, np.log(room.view.above)])


def find_foot(ends: Ends) -> Array:
    """The pixel (2,) below the middle of an outline, where it ends."""
    left, _, right, bottom = ends.at * [-1, 1, 1, 1]
    return np.array([(left + right) / 2, bottom])


def measure_hung(room: Room, one: Seen) -> Array | None:
    """Width and height (2,) of an outline on the wall that it lies on best, metres; None: it faces none."""
    farthest = max((float(box.center[1]) for box in room.boxes.values()), default=USUAL_FAR)
    walls = room.walls or [WallPlane(NORMALS[0], -farthest)]
    share, sides = max((measure_rectangle(room.view, wall, one.mask) for wall in walls), key=lambda each: each[0])
    return np.ptp(sides, axis=0) if share > 0 else None


def measure_resting(room: Room, ends: Ends, beneath: int) -> Array | None:
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


def weigh_looks(one: Seen, before: Mapping[str, float]) -> dict[str, float]:
    """How likely each name is by looks, by what was likely before, and by what COCO's network would have told."""
    looks = {each.name.replace(" ", "_"): each.probability for each in one.names.proposals}
    total, detected = sum(before.values()), list_detected()
    return {
        name: (looks.get(name, 0.0) + one.names.other * share / total) * (MISSED if name in detected else 1.0)
        for name, share in before.items()
    }


def name_by_size(camera: tuple[CameraPrior, Array], item: Item, one: Seen, carries: bool, rug: bool) -> str:
    """The name of what stands on the floor, by its looks and by how usual its size would be.

    carries: it carries something, so that it is one of the things that do. rug: it may be one.
    """
    known = known_categories()
    names = [name for name in list_names("floor") if rug or name != "rug"]
    names = [name for name in names if not carries or CARRIERS & set(known[name].kin)]
    before = weigh_looks(one, dict.fromkeys(names, 1.0))
    scores = {name: np.log(before[name]) - cost_of(camera, as_named(item, name)) for name in names}
    return max(names, key=lambda name: scores[name]).replace("_", " ")


def rename_by_size(camera: tuple[CameraPrior, Array], item: Item, one: Seen) -> str:
    """The best of the likely names of a known thing, by how usual its size would be."""
    likely = [each for each in one.names.proposals if each.probability > LIKELY] or one.names.proposals[:1]
    costs = [cost_of(camera, as_named(item, each.name.replace(" ", "_"))) for each in likely]
    scores = [np.log(each.probability) - cost for each, cost in zip(likely, costs, strict=True)]
    return likely[int(np.argmax(scores))].name


def name_by_extents(size: Array, far: float, one: Seen, before: Mapping[str, float]) -> str:
    """The name of what is so wide and high (2,), metres, by its looks and by how usual that is.

    far: deviation of the logarithm of its distance.
    """
    weights, scores = weigh_looks(one, before), dict[str, float]()
    for name, weight in weights.items():
        usual = usual_of(known_categories()[name])
        covariance = usual.covariance[np.ix_([0, 2], [0, 2])] + NOISE**2 * np.eye(2) + far**2
        off = np.log(np.maximum(size, 1e-3)) - usual.mean[[0, 2]]
        misfit = off @ np.linalg.solve(covariance, off) + np.linalg.slogdet(covariance)[1]
        scores[name] = float(np.log(weight) - misfit / 2)
    return max(scores, key=lambda name: scores[name]).replace("_", " ")


def as_named(item: Item, name: str) -> Item:
    """A thing as one of a category."""
    return replace(item, usual=usual_of(known_categories()[name]), legs=name in LEGGED)


def list_detected() -> set[str]:
    """The categories that a class of COCO often means: its network would have found one of those."""
    return {name for shares in read_coco().values() for name, share in shares.items() if share >= MEANT}


def cost_of(camera: tuple[CameraPrior, Array], item: Item) -> float:
    """Minus the logarithm of how likely a thing is where it is seen."""
    spread = float(np.linalg.slogdet(item.usual.covariance)[1]) / 2
    return float(choose_modes(camera[0], [item], camera[1])[1][0]) + spread
