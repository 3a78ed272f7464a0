"""Name the things of a picture, and decide which of them are placed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np

from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.geometry.frames import yaw_matrix
from roomkin.stages.geometry.masks import look_below
from roomkin.stages.perception.classification.names import (
    ODD,
    UNMEASURED,
    UNSURE,
    LikelyName,
    Names,
    carries,
    find_reason,
    may_carry,
    refuse_size,
)
from roomkin.stages.perception.classification.propose import Observed, observe, propose_names
from roomkin.stages.perception.layout.ends import number_masks
from roomkin.stages.perception.segmentation.choosing import ON_WALL, Outlined, share
from roomkin.stages.perception.segmentation.proposal import Array, Mask, RoomView
from roomkin.stages.perception.segmentation.ssd import NAMES as COCO_CLASSES

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
SELDOM = 0.1  # how seldom things of other kinds than `carries` tells carry some; chosen
TRIM = 0.03  # share of points left out at either end of an extent; chosen
BEHIND = "seen behind a wall: through a door, or in a mirror"
NOWHERE = np.full(3, np.nan)


@dataclass(frozen=True)
class Named:
    """A thing with its names, its extent low (3,) and high (3,) in the floor frame, metres, why it is left out, and
    what a language model states of it."""

    outlined: Outlined
    names: Names
    low: Array
    high: Array
    left_out: str = ""
    stated: Mapping[str, Any] = field(default_factory=dict)


def name_things(view: RoomView, things: Sequence[Outlined], sure: float) -> list[Named]:
    """The things with their names; what is not sure is left out, unless it carries what is placed, and may do so."""
    named = []
    for thing in things:
        try:
            named.append(decide(view, thing, sure))
        except ODD:
            by_words = propose_names(Observed(), thing.words or None)
            named.append(Named(thing, by_words, NOWHERE, NOWHERE, UNMEASURED))
    carriers = find_carriers(view, named)
    return [carry(one) if value in carriers else one for value, one in enumerate(named, 1)]


def carry(one: Named) -> Named:
    """A thing that carries another: a table or cupboard rather than a bed, and placed though its name is unsure."""
    names = one.names.weigh({kind: SELDOM for kind in known_categories() if not carries(kind)}, SELDOM)
    return replace(one, names=names, left_out="" if may_carry(one.names) and one.left_out in UNSURE else one.left_out)


def find_carriers(view: RoomView, named: Sequence[Named]) -> set[int]:
    """The things, by their places from 1, on which placed ones rest: as high below these, and no higher than they."""
    heights = np.where(view.depth > 0, view.surfaces.points[..., 2], np.nan)
    masks = number_masks({value: one.outlined.mask for value, one in enumerate(named, 1)}, heights.shape)
    found = set()
    for value, one in enumerate(named, 1):
        if one.left_out or one.outlined.flat:
            continue
        below = look_below(masks, value, [BELOW], heights, RESTS)
        if below and not named[below - 1].outlined.flat and one.high[2] > named[below - 1].high[2] - RESTS:
            found.add(below)
    return found


def name_outline(view: RoomView, mask: Mask, words: Mapping[str, float]) -> Names:
    """The names of what a person has outlined, (H, W); `words`: COCO's classes that were seen there, with scores."""
    flat = share(view.surfaces.beyond, mask & (view.depth > 0)) > ON_WALL
    return decide(view, Outlined(mask, 1.0, "click", words, flat), 0.0).names


def decide(view: RoomView, thing: Outlined, sure: float) -> Named:
    """A thing with its names, left out if it is not placed well or not known well."""
    surfaces, known = view.surfaces, thing.mask & (view.depth > 0)
    if known.sum() < max(3, MIN_KNOWN * thing.mask.sum()):
        share = 100 * known.sum() / max(thing.mask.sum(), 1)
        return Named(thing, name(view, thing, known), NOWHERE, NOWHERE, f"depth is known on {share:.0f} % of it alone")
    behind = known & surfaces.beyond & ~surfaces.on_wall
    shown = known & ~behind if thing.flat else known
    names = name(view, thing, shown)
    if thing.flat:
        names = names.restrict(MIRROR if behind.sum() > THROUGH * known.sum() else FLAT_CATEGORIES)
    if not shown.any():
        return Named(thing, names, NOWHERE, NOWHERE, BEHIND)
    low, high = np.quantile(surfaces.points[shown], [TRIM, 1 - TRIM], axis=0)
    names = refuse_size(names, measure_extents(surfaces.points[shown]))
    one = Named(thing, names, low, high)
    return replace(one, left_out=find_misplaced(view, one, known) or ("" if thing.flat else find_reason(names, sure)))


def measure_extents(points: Array) -> Array:
    """Extents (3,) of points (N, 3), metres, z up: along the smallest rectangle around them from above, and upright."""
    angle = np.deg2rad(cv2.minAreaRect(points[:, :2].astype(np.float32))[2])
    turned = points @ yaw_matrix(-angle).T
    return np.asarray(np.subtract(*np.quantile(turned, [1 - TRIM, TRIM], axis=0)))


def name(view: RoomView, thing: Outlined, known: Mask) -> Names:
    """The names of a thing by its looks, and by its shape where its depth is to be believed: `known` (H, W). A label
    that a detector was asked for stays, unless it is a category or COCO's: COCO's network was asked for none."""
    told, score = max(thing.words.items(), key=lambda each: each[1], default=("", 0.0))
    if told and told not in COCO_CLASSES.values() and told.replace(" ", "_") not in known_categories():
        return Names([LikelyName(told, score)], 1 - score)
    depth = np.where(thing.mask & ~known, 0, view.depth)
    seen = observe(view.rgb, depth, thing.mask, view.intrinsics, view.surfaces.frame)
    return propose_names(seen, thing.words or None)


def find_misplaced(view: RoomView, one: Named, known: Mask) -> str:
    """Why a thing is left out whatever its name is; empty: it lies where things do."""
    surfaces, low, high = view.surfaces, one.low, one.high
    lowest, tallest = DOOR
    if one.outlined.flat:
        is_door = low[2] < lowest and high[2] - low[2] > tallest
        return "flat on a wall and down to the ground: a door, or a window" if is_door else ""
    if (surfaces.beyond & known).sum() > BEYOND * known.sum():
        return BEHIND
    reach = [np.quantile(surfaces.points[known] @ wall.normal - wall.offset, TRIM) for wall in surfaces.walls]
    if low[2] > HIGH and min(reach, default=np.inf) > AT_WALL:
        return "high above the ground, and no wall holds it"
    return ""
