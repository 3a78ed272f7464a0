"""Mounting of objects (paper A.2): as the input states it or by geometry, and what they stand on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.category import CategoryFacts, may_stand_on
from roomkin.stages.contracts.objects import Box, Mounting, Wall
from roomkin.stages.contracts.types import FLOOR, UNNAMED, WALL
from roomkin.stages.extraction import contact
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.extraction.objects import MeasuredObject
from roomkin.stages.geometry.boxes import THINNEST, UprightBox, footprint, with_bottom, with_top
from roomkin.stages.geometry.frames import round_vector

SUNK = 0.04  # share of the distance by which an object reaches below the top of what it is in (a can in a bowl); chosen
MAX_STRETCH = 2.0  # of an object's seen height: by more its box is not extended down to what carries it; chosen


@dataclass(frozen=True)
class Placement:
    """Mounting (also by geometry alone), support, the box down to it, and that box with hidden space filled.

    collapsed: what looks high would become a thin plate on its carrier; then the depth of one is wrong.
    """

    mounting: Mounting
    measured: Mounting
    support: str
    box: UprightBox
    filled: UprightBox
    collapsed: bool


def mount_objects(
    scene: str,
    found: Sequence[MeasuredObject],
    image: AnnotatedImage,
    walls: list[Wall],
    shown: dict[int, Wall],
    view: contact.DepthView,
) -> list[MeasuredObject]:
    """The objects with mountings, supports, and boxes that reach down to these; supports are placed first.

    `scene` is named in messages; `shown`: the walls by the mask values that show them.
    """
    boxes = {one.object.id: one.box for one in found if one.box is not None}
    unnamed = ~np.isin(image.masks, image.annotations.values)
    carriers: dict[str, UprightBox] = {}
    done = {one.object.id: one for one in found}
    for name in sorted(boxes, key=lambda key: boxes[key].bottom):
        one, box = done[name], boxes[name]
        others = [other for key, other in boxes.items() if key != name]
        own = image.masks == one.object.mask
        stated, note = None, ""
        if one.stated.mounting is not None:
            stated, note = contact.resolve_stated_mounting(one.stated.mounting, box, shown)
            if note:
                print(f"{scene} {name}: {note}: mounting by geometry")
        known = one.stated.box is not None
        reach = 2 * view.tolerance(box.center)
        beneath = {
            key: end_near(each, done[key].heights, box.bottom, reach)
            for key, each in carriers.items()
            if may_stand_on(one.category, done[key].category)
        }
        placed = place_object(box, beneath, others, walls, view, own, known, stated, one.category, unnamed)
        if placed.collapsed:
            done[name] = one.fail("its top is found below what carries it: the depth of one of the two is wrong")
            continue
        carriers[name] = placed.filled
        size = round_vector(np.maximum(placed.box.size, 0.001))  # metres, also where its cloud has no depth
        update = {
            "box": Box(center=round_vector(placed.box.center), size=size, yaw=round(placed.box.yaw, 6)),
            "mounting": placed.mounting,
            "measured_support": placed.support,
            "measured_mounting": placed.measured if stated else None,
            "note": note,
        }
        done[name] = replace(one, object=one.object.model_copy(update=update))
    return list(done.values())


def end_near(carrier: UprightBox, heights: tuple[float, ...], bottom: float, reach: float) -> UprightBox:
    """A carrier's box, ending at the first of its heights within `reach` metres of the bottom of what it may carry."""
    near = next((height for height in heights if abs(height - bottom) < reach), None)
    return carrier if near is None else with_top(carrier, near)


def find_carrier(
    box: UprightBox, carriers: Mapping[str, UprightBox], tolerance: float, sunk: float = np.inf, share: float = 0.5
) -> tuple[float, str]:
    """Top of the highest carrier below a box and its id, or that of the floor.

    Args:
        carriers: boxes by id; `tolerance`: gap in metres that counts as touching.
        sunk: an object that reaches so many metres, and half of its height, below a carrier's top lies in the
        carrier, not on it; its bottom is that of its own box.
        share: least share of the box's footprint that lies over the carrier's, or within touching distance of it.
    """
    inside = max(sunk, float(box.size[2]) / 2)
    plan, touching = footprint(box), min(contact.CONTACT_DISTANCE, float(np.min(box.size[:2])) / 4)
    tops = [
        (carrier.top if carrier.top <= box.bottom + inside else box.bottom, name)
        for name, carrier in carriers.items()
        if plan.intersection(footprint(carrier).buffer(touching)).area > share * plan.area
        and carrier.top <= box.bottom + 2 * tolerance
        and carrier.top + carrier.bottom < box.top + box.bottom
    ]
    return max(tops, default=(0.0, FLOOR))


def place_object(
    box: UprightBox,
    carriers: Mapping[str, UprightBox],
    others: list[UprightBox],
    walls: list[Wall],
    view: contact.DepthView,
    own: NDArray[np.bool_],
    known: bool = False,
    stated: Mounting | None = None,
    category: CategoryFacts | None = None,
    unnamed: NDArray[np.bool_] | None = None,
) -> Placement:
    """Where one object stands or hangs.

    Args:
        box: of what was seen of it, at its `own` pixels (H, W).
        carriers: boxes of the objects that may carry it, hidden space filled, by id.
        others: boxes of all other objects, as seen.
        known: the box is known whole: nothing of it is hidden.
        stated: how it is held, if the input states it.
        category: of it; what never stands on the floor does not reach down to it from high above.
        unnamed: pixels (H, W) of no mask.
    """
    tolerance, sunk = view.tolerance(box.center), SUNK * view.distance(box.center)
    beneath, support = find_carrier(box, carriers, tolerance, sunk)
    touched = contact.find_touched_walls(box, others, walls, view, own, 0.0 if known else contact.MAX_HIDDEN_DEPTH)
    seen = box.top - box.bottom
    is_column = support == FLOOR and box.top > MAX_STRETCH * seen and not known
    if is_column and not (touched and contact.is_hanging(box, beneath, view, own)):
        height, near = find_carrier(box, carriers, tolerance, sunk, share=0.0)
        if box.bottom - height < 2 * tolerance:
            beneath, support = height, near
    is_stated = stated is not None and box.top - beneath < MAX_STRETCH * seen
    if unnamed is not None and not known and not is_stated and box.bottom - beneath > tolerance:
        shelf = contact.measure_shelf(box, walls, view, own, unnamed)
        if shelf is not None and shelf > beneath + tolerance:
            beneath, support = shelf, UNNAMED
    hangs = bool(touched) and (
        box.bottom - beneath > tolerance if known else contact.is_hanging(box, beneath, view, own)
    )
    if stated is None and category is not None and "floor" not in category.places:
        if is_column and support == FLOOR:  # in the air: a lamp of tables is no column
            hangs |= bool(touched) and "wall" in category.places
            beneath, support = box.bottom, UNNAMED
        hangs &= "wall" in category.places or support in (UNNAMED, FLOOR)
    measured = Mounting(type=1 if hangs else 3 if touched else 2, walls=[wall.id for wall in touched])
    mounting = stated or measured
    placed = box if known or mounting.hangs else with_bottom(box, min(beneath, box.top - THINNEST))
    behind = next((wall for wall in walls if wall.id in mounting.walls[:1]), None)
    if mounting.hangs:
        support = WALL
    elif placed.bottom - beneath > tolerance:  # a stated box stays where it is
        support = UNNAMED
    filled = placed if behind is None else contact.extend_to_wall(placed, behind)
    collapsed = bool(placed.size[2] < 1.5 * THINNEST and box.size[2] > tolerance)
    return Placement(mounting, measured, support, placed, filled, collapsed)
