"""Mounting of an object by geometry (paper A.2): what it stands on, and which walls it touches."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.config.extraction import ExtractionConfig
from stages.contracts.objects import Mounting, Wall
from stages.extraction.clouds import THINNEST, with_bottom
from stages.extraction.foot import height_shown, reaches_down
from stages.extraction.masks import OUTLINE
from stages.extraction.visibility import DepthView, cell_centres
from stages.extraction.walls import filled_to, walls_touched
from stages.geometry.boxes import UprightBox, footprint
from stages.geometry.frames import yaw_matrix

BESIDE, BESIDE_SMALL = 0.05, 0.25  # metres by which footprints are widened; at most so much of what stands on them
ON_TOP = 0.5  # share of the upper footprint that lies over the lower one
JUST_BELOW = 0.15  # metres
SUNK = 0.04  # share of the distance, by which what is in a thing reaches down below its top
STRETCHED = 2.0  # times its seen height, up to which what is said to stand reaches down to what carries it
FLOOR, WALL, UNNAMED = "floor", "wall", "unnamed"


@dataclass(frozen=True)
class Placement:
    """How an object is held, and by geometry alone; on what; its box down to that, and with hidden space filled."""

    mounting: Mounting
    measured: Mounting
    support: str
    box: UprightBox
    filled: UprightBox


def collapsed(seen: UprightBox, placed: Placement, tolerance: float) -> bool:
    """Whether an object that is seen to be high would become a thin plate on its carrier: the depth of one is wrong."""
    height, left = seen.size[2], placed.box.size[2]
    return bool(left < 1.5 * THINNEST and height > tolerance)


def carrier_beneath(
    box: UprightBox, carriers: Mapping[str, UprightBox], tolerance: float, sunk: float = np.inf, share: float = ON_TOP
) -> tuple[float, str]:
    """Top of the highest carrier below the box and its id, or that of the floor.

    It lies under more than a `share` of the box. What reaches down by more than `sunk` metres and half of its height
    below a top is not on it, but in it (a can in a bowl), and stands where it ends.
    """
    inside = max(sunk, float(box.size[2]) / 2)
    plan = footprint(box)
    widened = min(BESIDE, BESIDE_SMALL * float(np.min(box.size[:2])))
    tops = [
        (carrier.top if carrier.top <= box.bottom + inside else box.bottom, name)
        for name, carrier in carriers.items()
        if plan.intersection(footprint(carrier).buffer(widened)).area > share * plan.area
        and carrier.top <= box.bottom + 2 * tolerance
        and carrier.top + carrier.bottom < box.top + box.bottom
    ]
    return max(tops, default=(0.0, FLOOR))


def free_space_beneath(box: UprightBox, height: float, view: DepthView, own: NDArray[np.bool_]) -> float:
    """Share of the space just below the box, down to `height` at most, that the camera has seen to be empty.

    Farther down furniture may stand before it: a picture above a sofa hangs all the same.
    """
    half = box.size[:2] / 2
    low = max(height, box.bottom - JUST_BELOW)
    local = cell_centres(np.array([*-half, low]), np.array([*half, box.bottom]), (6, 6, 8))
    return view.free_space_share(local @ yaw_matrix(box.yaw).T + [*box.center[:2], 0.0], own)


def placement(
    box: UprightBox,
    carriers: Mapping[str, UprightBox],
    others: list[UprightBox],
    walls: list[Wall],
    view: DepthView,
    own: NDArray[np.bool_],
    options: ExtractionConfig,
    known: bool = False,
    stated: Mounting | None = None,
    is_seat: bool = False,
    unnamed: NDArray[np.bool_] | None = None,
) -> Placement:
    """Where one object stands or hangs.

    Args:
        box: of what was seen of it.
        carriers: boxes of the objects that may be beneath it, hidden space filled, by id.
        others: boxes of all other objects, as seen.
        walls: all wall planes.
        view: the picture's depth, by which hidden space is told from empty space.
        own: the object's pixels (H, W).
        options: tolerances.
        known: the box is known whole, so that nothing hidden has to be guessed.
        stated: how it is held, if the input says so.
        is_seat: it stands on the floor however little is seen of it above a table.
        unnamed: pixels (H, W) of which nobody said what they show.
    """
    if known:
        options = options.model_copy(update={"max_hidden_depth": 0.0})
    distance = view.distance(box.center)
    tolerance = options.tolerance(view.error.at(distance))
    beneath, support = carrier_beneath(box, carriers, tolerance, SUNK * distance)
    seen = box.top - box.bottom
    touched = walls_touched(box, others, walls, view, own, options)
    column = support == FLOOR and box.top > STRETCHED * seen and not (known or is_seat)
    if column and not (touched and _hangs(box, beneath, tolerance, view, own, options)):
        height, beside = carrier_beneath(box, carriers, tolerance, SUNK * distance, share=0.0)
        if box.bottom - height < 2 * tolerance:
            beneath, support = height, beside
    said = stated is not None and box.top - beneath < STRETCHED * seen
    if unnamed is not None and not known and not said and box.bottom - beneath > tolerance:
        shelf = height_shown(box, walls, view, own, unnamed, tolerance)
        if shelf is not None and shelf > beneath + tolerance:
            beneath, support = shelf, UNNAMED
    if known:
        hangs = bool(touched) and box.bottom - beneath > tolerance
    else:
        hangs = bool(touched) and _hangs(box, beneath, tolerance, view, own, options)
    measured = Mounting(type=1 if hangs else 3 if touched else 2, walls=[wall.id for wall in touched])
    mounting = stated or measured
    standing = box if known or mounting.type == 1 else with_bottom(box, min(beneath, box.top - THINNEST))
    behind = next((wall for wall in walls if wall.id in mounting.walls[:1]), None)
    if mounting.type == 1:
        support = WALL
    elif standing.bottom - beneath > tolerance:  # a box that was told stays where it is
        support = UNNAMED
    return Placement(mounting, measured, support, standing, standing if behind is None else filled_to(standing, behind))


def _hangs(
    box: UprightBox,
    beneath: float,
    tolerance: float,
    view: DepthView,
    own: NDArray[np.bool_],
    options: ExtractionConfig,
) -> bool:
    """Whether what touches a wall is seen to end above what is beneath it, a height.

    Depth errs along the view, so a low edge is as sharp as the picture, however far away.
    """
    return (
        box.bottom - beneath > OUTLINE * view.pixel_size(view.distance(box.center))
        and not reaches_down(box, beneath, tolerance, view, own)
        and free_space_beneath(box, beneath, view, own) >= options.free_space_share
    )
