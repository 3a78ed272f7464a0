"""Name the things of a picture, and decide which of them are placed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plugins.eyes.choosing import ON_WALL, Outlined, share
from plugins.eyes.proposal import Array, Mask, RoomView
from plugins.names.observed import observe
from plugins.names.propose import Names, Proposal, propose_names
from stages.contracts.categories import known_categories
from stages.extraction.contact import lowest_pixels

# What may be flat on a wall, and how likely each is, before its looks are seen; chosen.
FLAT_CATEGORIES = {"picture": 0.5, "mirror": 0.2, "television": 0.1, "clock": 0.05, "radiator": 0.05, "curtain": 0.05}
MIRROR = {"mirror": 0.9, "picture": 0.1}  # likewise, if much is seen behind it; chosen
THROUGH = 0.2  # share of a flat thing through which what is behind its wall is seen, from which on it is so; chosen
DOOR = 0.3, 1.6  # metres above the ground to which a door or window reaches down, and its least height; chosen
MIN_KNOWN = 0.2  # share of a thing's pixels with depth, below which nobody knows where it is; chosen
BEYOND = 0.5  # share of a thing that is seen behind a wall, above which it is in another room, or in a mirror; chosen
HIGH = 1.6  # metres above the ground from which what no wall holds hangs from the ceiling; chosen
AT_WALL = 0.15  # metres from a thing to a wall that holds it; chosen
RESTS, BELOW = 0.08, 4  # metres between what carries and what is carried; pixels below the latter; chosen
CARRIERS, SELDOM = {"appliance", "storage", "table"}, 0.1  # kinds that carry things, and how seldom others do; chosen
TRIM = 0.03  # share of points left out at either end of an extent; chosen
NO_KIND, NO_NAME = "more likely nothing that the library has", "no name is sure enough"
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
    placed = [one for one in named if not one.left_out and not one.outlined.flat]
    heights = np.where(view.depth > 0, view.surfaces.points[..., 2], np.nan)
    return [carry(one) if any(rests_on(heights, other, one) for other in placed) else one for one in named]


def carry(one: Named) -> Named:
    """A thing that carries another: a table or cupboard rather than a bed, and placed however unsure its name is."""
    names, known = one.names, known_categories()
    kinds = [set(known[each.name.replace(" ", "_")].kin) for each in names.proposals]
    shares = [
        each.probability * (1 if CARRIERS & kin else SELDOM) for each, kin in zip(names.proposals, kinds, strict=True)
    ]
    total = sum(shares) + SELDOM * names.other
    weighed = [each._replace(probability=part / total) for each, part in zip(names.proposals, shares, strict=True)]
    weighed.sort(key=lambda each: -each.probability)
    left_out = "" if one.left_out in UNSURE else one.left_out
    return replace(one, names=Names(weighed, SELDOM * names.other / total), left_out=left_out)


def rests_on(heights: Array, other: Named, one: Named) -> bool:
    """Whether below most of a thing's lower edge the picture shows another, as high, that reaches no higher than it.

    `heights`: (H, W) of the pixels above the ground, metres, NaN: unknown.
    """
    if other is one or one.outlined.flat or not other.high[2] > one.high[2] - RESTS:
        return False
    columns, rows = lowest_pixels(other.outlined.mask)
    inside = rows + BELOW < len(heights)
    columns, rows = columns[inside], rows[inside]
    below, step = one.outlined.mask[rows + BELOW, columns], heights[rows + BELOW, columns] - heights[rows, columns]
    return bool((below & (np.abs(step) < RESTS)).sum() > len(columns) / 2)


def name_outline(view: RoomView, mask: Mask, words: Mapping[str, float]) -> Names:
    """The names of what a person has outlined, (H, W); `words`: COCO's classes that were seen there, with scores."""
    flat = share(view.surfaces.beyond, mask & (view.depth > 0)) > ON_WALL
    return decide(view, Outlined(mask, 1.0, "click", words, flat), 0.0).names


def decide(view: RoomView, thing: Outlined, sure: float) -> Named:
    """A thing with its names, left out if it is not placed well or not known well."""
    surfaces, known = view.surfaces, thing.mask & (view.depth > 0)
    if known.sum() < max(3, MIN_KNOWN * thing.mask.sum()):
        share = 100 * known.sum() / thing.mask.sum()
        nowhere = np.full(3, np.nan)
        return Named(thing, name(view, thing, known), nowhere, nowhere, f"depth is known on {share:.0f} % of it alone")
    behind = known & surfaces.beyond & ~surfaces.on_wall
    names = name(view, thing, known & ~behind if thing.flat else known)
    if thing.flat:
        names = keep_flat(names, MIRROR if behind.sum() > THROUGH * known.sum() else FLAT_CATEGORIES)
    points = surfaces.points[known & ~behind if thing.flat else known]
    low, high = np.quantile(points, [TRIM, 1 - TRIM], axis=0)
    one = Named(thing, names, low, high)
    return replace(one, left_out=find_reason(view, one, known, sure))


def name(view: RoomView, thing: Outlined, known: Mask) -> Names:
    """The names of a thing by its looks, and by its shape where its depth is to be believed: `known` (H, W)."""
    depth = np.where(thing.mask & ~known, 0, view.depth)
    seen = observe(view.rgb, depth, thing.mask, view.intrinsics, view.surfaces.frame)
    return propose_names(seen, thing.words or None)


def find_reason(view: RoomView, one: Named, known: Mask, sure: float) -> str:
    """Why a thing is left out; empty: it is placed."""
    surfaces, names, low, high = view.surfaces, one.names, one.low, one.high
    lowest, tallest = DOOR
    if one.outlined.flat:
        is_door = low[2] < lowest and high[2] - low[2] > tallest
        return "flat on a wall and down to the ground: a door, or a window" if is_door else ""
    if (surfaces.beyond & known).sum() > BEYOND * known.sum():
        return "seen behind a wall: through a door, or in a mirror"
    reach = [np.quantile(surfaces.points[known] @ wall.normal - wall.offset, TRIM) for wall in surfaces.walls]
    if low[2] > HIGH and min(reach, default=np.inf) > AT_WALL:
        return "high above the ground, and no wall holds it"
    if names.other > names.proposals[0].probability:
        return NO_KIND
    return NO_NAME if names.proposals[0].probability < sure else ""


def keep_flat(names: Names, priors: Mapping[str, float]) -> Names:
    """The names of a thing that is flat on a wall: it is one of a few; what none of them is, is shared by priors."""
    said = {one.name: one.probability for one in names.proposals}
    shares = {kind: said.get(kind, 0.0) + prior * names.other for kind, prior in priors.items()}
    total = sum(shares.values())
    kept = [Proposal(kind, share / total if total else priors[kind]) for kind, share in shares.items()]
    return Names(sorted(kept, key=lambda one: -one.probability), 0.0)
