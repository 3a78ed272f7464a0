"""Things in random rooms of our own models, as a sensor sees them, with their categories."""

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plugins.furniture.catalogue import CATEGORIES
from plugins.names.observed import Observed, observe
from plugins.segmenter.training.pictures import LARGE, NOTHING, Picture, make_pool, pictures_in
from plugins.segmenter.training.rooms import Room, furnish
from plugins.segmenter.training.sensor import photograph, sense_depth, tilt_frame
from plugins.segmenter.training.solids import Rng

LEAST = 80  # pixels of a mask in a picture of 320 x 240
VIEWS = 6  # of a room
AS_IF = {"office_chair": "chair"}  # kinds that the library lacks


class Example(NamedTuple):
    """A category, and what is observed of a thing of it."""

    name: str
    observed: Observed


def draw_examples(each: int, models: int, seed: int, rooms: int) -> list[Example]:
    """At most `each` of every category, of so many models a kind, in at most so many rooms."""
    rng, pool = np.random.default_rng(seed), make_pool(models, seed)
    found: list[Example] = []
    counts: Counter[str] = Counter()
    for _ in range(rooms):
        room = furnish(pool, rng)
        for picture in pictures_in(room, LARGE, VIEWS, rng):
            found += look_at(picture, room, counts, each, rng)
        if len(counts) == len(CATEGORIES) and min(counts.values()) >= each:
            break
    return found


def look_at(picture: Picture, room: Room, counts: Counter[str], each: int, rng: Rng) -> list[Example]:
    """The things of a picture of whose category there are less than `each`; they are counted."""
    depth, frame, rgb = sense_depth(picture, rng), tilt_frame(picture.frame.astype(float), rng), picture.rgb
    changed = photograph(rgb, rng)
    rgb = changed if np.ptp(changed) > 0 else rgb  # at times a sensor has no colour at all
    found = []
    for owner in np.unique(picture.owner[(picture.owner > 1) & (picture.owner != NOTHING)]):
        kind = room.things[int(owner) - 2].solid.kind
        name = AS_IF.get(kind, kind)
        mask: NDArray[np.bool_] = picture.owner == owner
        if name in CATEGORIES and counts[name] < each and mask.sum() >= LEAST:
            found.append(Example(name, observe(rgb, depth, mask, picture.intrinsics, frame)))
            counts[name] += 1
    return found
