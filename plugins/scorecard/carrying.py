"""What carries what, and what is inside what, of boxes in the world."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.scorecard.submission import SubmittedThing
from roomkin.plugins.scorecard.truth import TrueThing
from roomkin.stages.geometry.boxes import UprightBox, corners, footprint

ON, AT_WALL = 0.05, 0.10  # metres between a thing and what carries it, and the wall that it hangs on
INSIDE = 0.02  # metres by which things may be in each other more than the true ones are
BELOW = 0.05  # metres by which a box may be under the floor


def find_support(place: int, boxes: Sequence[UprightBox], room: tuple[float, float]) -> str:
    """What carries a thing that does not say so: floor, wall, the place of another, or nothing.

    Args:
        place: of the thing in the list.
        boxes: all things, in the world.
        room: extents of the floor along x and y, metres.
    """
    box = boxes[place]
    under, best = footprint(box), (0.0, "")
    for other, carrier in enumerate(boxes):
        reaches = carrier.bottom < box.bottom - ON and carrier.top > box.bottom - ON
        share = under.intersection(footprint(carrier)).area if other != place and reaches else 0.0
        best = max(best, (share, str(other)))
    if box.bottom <= ON:
        return "floor"
    if best[0] > 0.3 * under.area:
        return best[1]
    points = corners(box)[:, :2]
    gap = min((np.array(room) - points).min(), points.min())
    return "wall" if gap < AT_WALL else ""


def list_supports(
    things: Sequence[SubmittedThing], boxes: Sequence[UprightBox], room: tuple[float, float]
) -> list[str]:
    """What carries every thing: as it says, else as its box tells."""
    return [thing.support or find_support(place, boxes, room) for place, thing in enumerate(things)]


def is_carrier_right(thing: TrueThing, support: str, pairs: Mapping[int, int], asked: Sequence[int]) -> bool | None:
    """Whether a thing is carried by what truly carries it; None: that is nothing that was asked for."""
    if thing.support in ("floor", "wall"):
        return support == thing.support
    true = int(thing.support)
    return true in pairs and support == str(pairs[true]) if true in asked else None


def measure_overlap(one: UprightBox, other: UprightBox) -> float:
    """The least shift that parts two upright boxes, metres; 0: they are apart."""
    up = min(one.top, other.top) - max(one.bottom, other.bottom)
    if up <= 0:
        return 0.0
    a, b = corners(one)[:4, :2], corners(other)[:4, :2]
    least = up
    for yaw in (one.yaw, one.yaw + np.pi / 2, other.yaw, other.yaw + np.pi / 2):
        axis = np.array([np.cos(yaw), np.sin(yaw)])
        p, q = a @ axis, b @ axis
        least = min(least, min(p.max(), q.max()) - max(p.min(), q.min()))
    return float(max(least, 0.0))


def find_inside(
    boxes: Sequence[UprightBox],
    truth: Mapping[int, UprightBox],
    depths: NDArray[np.float64] | None = None,
    pieces: Collection[int] = (),
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Overlaps (N, N) of things, metres, and which things are in something (N,).

    A chair under its table and a pillow on a bed are in each other's boxes in truth: a pair of which one is a box
    counts by what it is more. Meshes are in nothing in truth.

    Args:
        boxes: submitted, in the world.
        truth: box of the true thing by place of the submitted one, of those that stand for one.
        depths: (N, N) of `measure_depths`, for pairs of which one at least has a shape.
        pieces: places of those that have one.
    """
    overlaps = np.zeros((len(boxes), len(boxes)))
    inside = np.array([box.bottom < -BELOW for box in boxes], dtype=bool)
    for i in range(len(boxes)):
        for j in range(i):
            shaped = (i in pieces) + (j in pieces)
            depth = measure_overlap(boxes[i], boxes[j]) if depths is None or not shaped else depths[i, j]
            overlaps[i, j] = overlaps[j, i] = depth
            right = measure_overlap(truth[i], truth[j]) if i in truth and j in truth and shaped < 2 else 0.0
            if overlaps[i, j] > right + INSIDE:
                inside[[i, j]] = True
    return overlaps, inside
