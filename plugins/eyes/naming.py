"""Name the things of a picture, and decide which of them are placed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plugins.eyes.choosing import Outlined
from plugins.eyes.proposal import Array, RoomView
from plugins.names.observed import observe
from plugins.names.propose import Names, Proposal, propose_names

FLAT = {
    "clock",
    "curtain",
    "mirror",
    "monitor",
    "picture",
    "radiator",
    "television",
    "wall shelf",
}  # may be flat on walls
DOOR = 0.3, 1.6  # metres above the ground to which a door or window reaches down, and its least height; chosen
LEAST_KNOWN = 0.2  # share of a thing's pixels with depth, below which nobody knows where it is; chosen
BEYOND = 0.5  # share of a thing that is seen behind a wall, above which it is in another room, or in a mirror; chosen
HIGH = 1.6  # metres above the ground from which what no wall holds hangs from the ceiling; chosen
AT_WALL = 0.15  # metres from a thing to a wall that holds it; chosen
RESTS = 0.08  # metres between the top of what carries and the bottom of what is carried; chosen
TRIM = 0.03  # share of points left out at either end of an extent; chosen
NO_KIND, NO_NAME = "looks like nothing that the library has", "no name is sure enough"
UNSURE = (NO_KIND, NO_NAME)


@dataclass(frozen=True)
class Named:
    """A thing with its names, its extent low (3,) and high (3,) in the floor frame, metres, and why it is left out."""

    outlined: Outlined
    names: Names
    low: Array
    high: Array
    left_out: str = ""


def name_things(view: RoomView, things: Sequence[Outlined], sure: float) -> list[Named]:
    """The things with their names; what is not sure is left out, unless it carries what is placed."""
    named = [decide(view, thing, sure) for thing in things]
    return [replace(one, left_out="") if one.left_out in UNSURE and carries(one, named) else one for one in named]


def decide(view: RoomView, thing: Outlined, sure: float) -> Named:
    """A thing with its names, left out if it is not placed well or not known well."""
    surfaces, known = view.surfaces, thing.mask & (view.depth > 0)
    names = propose_names(
        observe(view.rgb, view.depth, thing.mask, view.intrinsics, surfaces.frame), thing.words or None
    )
    if known.sum() < max(3, LEAST_KNOWN * thing.mask.sum()):
        share = 100 * known.sum() / thing.mask.sum()
        nowhere = np.full(3, np.nan)
        return Named(thing, names, nowhere, nowhere, f"depth is known on {share:.0f} % of it alone")
    points = surfaces.points[known]
    low, high = np.quantile(points, [TRIM, 1 - TRIM], axis=0)
    if thing.flat:
        names = keep_flat(names)
    one = Named(thing, names, low, high)
    first = names.proposals[0]
    lowest, tallest = DOOR
    if thing.flat and low[2] < lowest and high[2] - low[2] > tallest:
        return replace(one, left_out="flat on a wall and down to the ground: a door, or a window")
    if not thing.flat and (surfaces.beyond & known).sum() > BEYOND * known.sum():
        return replace(one, left_out="seen behind a wall: through a door, or in a mirror")
    reach = [np.quantile(points @ wall.normal - wall.offset, TRIM) for wall in surfaces.walls]
    if not thing.flat and low[2] > HIGH and min(reach, default=np.inf) > AT_WALL:
        return replace(one, left_out="high above the ground, and no wall holds it")
    if names.other > first.probability:
        return replace(one, left_out=NO_KIND)
    if first.probability < sure:
        return replace(one, left_out=NO_NAME)
    return one


def keep_flat(names: Names) -> Names:
    """The names that a thing may have that is flat on a wall; a picture, if none is likely."""
    flat = [one for one in names.proposals if one.name in FLAT]
    total = sum(one.probability for one in flat) + names.other
    if not total:
        return Names([Proposal("picture", 1.0)], 0.0)
    kept = [one._replace(probability=one.probability / total) for one in flat]
    return Names(kept, names.other / total)


def carries(one: Named, others: Sequence[Named]) -> bool:
    """Whether something that is placed rests on a thing's top."""
    for other in others:
        middle = (other.low + other.high) / 2
        over = (one.low[:2] < middle[:2]).all() and (middle[:2] < one.high[:2]).all()
        if not other.left_out and not other.outlined.flat and over and abs(other.low[2] - one.high[2]) < RESTS:
            return True
    return False
