"""Which outlines are things, and their names: by looks, by where they stand and by how large that makes them."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plugins.eyes.proposal import find_border
from plugins.inputs.photo.metrology import WallPlane
from plugins.names.propose import read_coco
from plugins.single_view.ends import Ends, measure_all
from plugins.single_view.fit import CameraPrior, Item, Usual
from plugins.single_view.modes import choose_modes
from plugins.single_view.room import NORMALS, Room, usual_of
from plugins.single_view.supports import CARRIERS, FLOOR, LEGGED, category_of, find_open
from plugins.single_view.things import Seen, number_masks
from plugins.single_view.walls import measure_rectangle
from stages.contracts.categories import known_categories

Array = NDArray[np.float64]
ANYTHING = Usual(np.log([1.0, 0.6, 1.0]), np.diag([1.0, 1.0, 1.0]))  # width, depth, height of what has no name; chosen
LOW = -0.15  # slope of a ray to the floor: what is farther is too far for a room; chosen
MISSED = 0.3  # how likely COCO's network misses a thing that it knows; chosen
MEANT = 0.2  # share of what a class of COCO is said of, from which on it means a category; chosen
LIKELY = 0.1  # least probability of a name that size may choose; chosen
LEAST_LOOKS = 0.02  # least share of a name by looks alone, which know little of it; chosen
LEAST = 0.003  # share of the picture that an outline without a known class covers at least; chosen
ALIGNED = 0.15  # of their width, by which the sides of pieces of one front are apart at most; chosen
RECTANGLE = 0.85  # least share of its rectangle that what hangs flat fills; chosen
CRISP = 0.93  # least score of its outline; chosen
USUAL_FAR = 3.0  # metres to a wall before which nothing is known; chosen
LEAST_HIGH = 0.8  # metres from the floor to what hangs flat; chosen
FLAT_WIDTH = 0.12, 1.6  # metres of what hangs flat; chosen


def name_outlines(
    rgb: NDArray[np.uint8], seen: Sequence[Seen], room: Room, labels: Mapping[int, str]
) -> tuple[list[Seen], dict[int, str]]:
    """The outlines, and labels of what stands on the floor, carries a known thing, or hangs flat on a wall.

    Args:
        rgb: (H, W, 3).
        seen: all outlines; the value of a mask is its place, from 1.
        room: of those that have `labels`.
    """
    seen = join_stacked(rgb, seen, labels)
    ends = measure_outlines(rgb, seen)
    floor = find_floor(ends, room, labels)
    feet = {value: one.met[3] for value, one in ends.items()}
    ends = dict(ends) | measure_outlines(rgb, seen, floor)  # the floor hides nothing
    beneath = {feet[value] for value in labels if must_be_carried(labels[value])}
    found, camera = dict[int, str](), as_camera(room)
    for value, one in enumerate(seen, 1):
        if not one.mask.any():
            continue
        item = Item(ends[value], find_open(value, ends, dict.fromkeys(ends, FLOOR)), ANYTHING)
        if room.on.get(value) == FLOOR:
            found[value] = rename_by_size(camera, item, one)
        elif value in labels or value in floor or one.mask.mean() < LEAST:
            continue
        elif hangs_flat(room, one, ends[value]):
            found[value] = "picture"
        elif value in beneath or stands_free(ends[value], feet[value], floor, labels, room):
            name = name_by_size(camera, item, one, value in beneath, feet[value] in floor)
            found |= {value: name} if name else {}
    return seen, found


def measure_outlines(rgb: NDArray[np.uint8], seen: Sequence[Seen], floor: Collection[int] = ()) -> Mapping[int, Ends]:
    """The ends of all outlines but those of the floor, by their places from 1; of those that show nothing none."""
    masks = number_masks(rgb, {value: one for value, one in enumerate(seen, 1) if value not in floor})
    return measure_all(masks, [value for value in range(1, len(seen) + 1) if (masks == value).any()], ~find_border(rgb))


def join_stacked(rgb: NDArray[np.uint8], seen: Sequence[Seen], labels: Mapping[int, str]) -> list[Seen]:
    """The outlines, those that lie right above another and are as wide joined to it: drawers over doors.

    The lower one takes the pixels; the other shows nothing.
    """
    joined, ends = list(seen), measure_outlines(rgb, seen)
    for value in sorted(ends, key=lambda value: -ends[value].at[3]):
        below, own = ends[value].met[3], ends[value].at
        if {value, below} & {0, *labels} or below not in ends:
            continue
        other = ends[below].at
        wide = min(own[0] + own[2], other[0] + other[2])
        aligned = max(abs(own[0] - other[0]), abs(own[2] - other[2])) < ALIGNED * wide
        if aligned and joined[below - 1].mask.any():
            upper, lower = joined[value - 1], joined[below - 1]
            joined[below - 1] = replace(lower, mask=lower.mask | upper.mask)
            joined[value - 1] = replace(upper, mask=np.zeros_like(upper.mask))
    return joined


def stands_free(ends: Ends, foot: int, floor: set[int], labels: Mapping[int, str], room: Room) -> bool:
    """Whether an outline may stand on the floor: it ends there, or where nobody knows the floor, far below the horizon
    and not at another thing; `foot`: the outline below it."""
    left, _, right, bottom = ends.at * [-1, 1, 1, 1]
    if ends.cut[1] or room.view.rays([(left + right) / 2, bottom])[2] > LOW:
        return False
    return foot in floor or (not floor and foot not in labels)


def find_floor(ends: Mapping[int, Ends], room: Room, labels: Mapping[int, str]) -> set[int]:
    """The outlines that show the floor: below what stands on it."""
    standing = [value for value, on in room.on.items() if on == FLOOR and not must_be_carried(labels[value])]
    return {ends[value].met[3] for value in standing if not ends[value].cut[3]} - set(labels) - {0}


def must_be_carried(label: str) -> bool:
    """Whether things of a label stand on others alone."""
    category = category_of(label)
    return category is not None and category.places == ["top"]


def as_camera(room: Room) -> tuple[CameraPrior, Array]:
    """The camera of a room, as a fit takes it, and as a state."""
    prior = CameraPrior(room.perspective, room.view)
    return prior, np.array([*prior.state, np.log(room.view.above)])


def hangs_flat(room: Room, one: Seen, ends: Ends) -> bool:
    """Whether an outline is an upright rectangle on a wall, of the size of a picture, clear of floor and border."""
    if ends.cut.any() or one.score < CRISP:
        return False
    farthest = max((float(box.center[1]) for box in room.boxes.values()), default=USUAL_FAR)
    walls = room.walls or [WallPlane(NORMALS[0], -farthest)]
    shares = [measure_rectangle(room.view, wall, one.mask) for wall in walls]
    share, sides = max(shares, key=lambda each: each[0])
    width, height = np.ptp(sides, axis=0)
    low, high = FLAT_WIDTH
    return bool(
        share > RECTANGLE and low < min(width, height) and max(width, height) < high and sides[0, 1] > LEAST_HIGH
    )


def name_by_size(camera: tuple[CameraPrior, Array], item: Item, one: Seen, carries: bool, rug: bool) -> str:
    """The name of what stands on the floor, by its looks and by how usual its size would be; empty: none.

    carries: it carries something, so that it is a thing, and one of those that do. rug: it may be one.
    """
    known = known_categories()
    looks = {each.name.replace(" ", "_"): each.probability for each in one.names.proposals}
    total = sum(looks.values())
    names = [
        name
        for name, category in known.items()
        if "floor" in category.places and (rug or name != "rug") and (not carries or CARRIERS & set(category.kin))
    ]
    before = {name: max(looks.get(name, 0.0) / total, LEAST_LOOKS) for name in names}
    before |= {name: MISSED * before[name] for name in list_detected() & set(names)}
    tried = [as_named(item, name) for name in names]
    scores = [np.log(before[name]) - cost_of(camera, one) for name, one in zip(names, tried, strict=True)]
    return names[int(np.argmax(scores))].replace("_", " ")


def rename_by_size(camera: tuple[CameraPrior, Array], item: Item, one: Seen) -> str:
    """The best of the likely names of a known thing, by how usual its size would be."""
    likely = [each for each in one.names.proposals if each.probability > LIKELY] or one.names.proposals[:1]
    costs = [cost_of(camera, as_named(item, each.name.replace(" ", "_"))) for each in likely]
    scores = [np.log(each.probability) - cost for each, cost in zip(likely, costs, strict=True)]
    return likely[int(np.argmax(scores))].name


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
