"""Examples of shapes with their names, from random rooms of our own models, by several processes."""

from collections.abc import Iterator
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.name_training.dirt import OTHER, SAME, Mask, cut_patch, share_owner, soil
from benchmarks.name_training.pictures import BACKGROUND, NOTHING, Picture, pictures_in, sense_depth, tilt_frame
from benchmarks.name_training.rooms import Room, furnish, make_pool
from benchmarks.name_training.solids import Rng
from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.stages.geometry.cameras import back_project
from roomkin.stages.geometry.frames import transform_points
from roomkin.stages.perception.classification.network import NUMBERS
from roomkin.stages.perception.classification.propose import AROUND, POINTS, Shape, measure_shape

MIN_PIXELS = 60  # pixels of a mask in a picture of 320 x 240
VIEWS = 7  # of a room
PATCHES = 1  # of no thing, in a picture
NONE = "other"
AS_IF = {"office_chair": "chair"}  # a kind of the rooms that the library lacks


class Examples(NamedTuple):
    """points (N, POINTS, 3), around (N, AROUND, 3) float16, numbers (N, 8) float32; name (N,) of `list_names`."""

    points: NDArray[np.float16]
    around: NDArray[np.float16]
    numbers: NDArray[np.float32]
    name: NDArray[np.int64]


def list_names() -> list[str]:
    """The categories of the library, sorted, and last: none of them."""
    return [*sorted(CATEGORIES), NONE]


def name_kind(kind: str) -> str:
    """The name of a kind of the rooms."""
    name = AS_IF.get(kind, kind)
    return name if name in CATEGORIES else NONE


def draw_examples(rooms: int, models: int, seed: int, processes: int = 1, packs: Path | None = None) -> Examples:
    """Things of so many rooms that are furnished with so many models of a kind; the same by any number of processes.

    packs: other people's models beside, see `make_pool`.
    """
    draw = partial(draw_room, models, seed, packs)
    if processes == 1:
        drawn = [draw(number) for number in range(rooms)]
    else:
        with get_context("spawn").Pool(processes) as pool:
            drawn = pool.map(draw, range(rooms), chunksize=4)
    return Examples(*(np.concatenate(each) for each in zip(*drawn, strict=True)))


def draw_room(models: int, seed: int, packs: Path | None, number: int) -> Examples:
    """The examples of a room."""
    rng, names = np.random.default_rng((seed, number)), list_names()
    room = furnish(make_pool(models, seed, packs), rng)
    found = [one for picture in pictures_in(room, VIEWS, rng) for one in look_at(picture, room, rng)]
    return Examples(
        np.array([shape.points for _, shape in found], np.float16).reshape(-1, POINTS, 3),
        np.array([shape.around for _, shape in found], np.float16).reshape(-1, AROUND, 3),
        np.array([shape.numbers for _, shape in found], np.float32).reshape(-1, NUMBERS),
        np.array([names.index(name) for name, _ in found], np.int64),
    )


def look_at(picture: Picture, room: Room, rng: Rng) -> Iterator[tuple[str, Shape]]:
    """The masks of a picture that show a thing or none, with the name, as a sensor sees them."""
    depth, frame = sense_depth(picture, rng), tilt_frame(picture.frame, rng)
    points, known = transform_points(frame, back_project(depth, picture.intrinsics)), depth > 0
    wholes = find_wholes(picture, room)
    masks = [soil(some[-1 if rng.random() < 0.3 else 0], picture.owner, rng) for some in wholes.values()]
    masks += [cut_patch(picture.owner <= BACKGROUND, rng) for _ in range(PATCHES)]
    for mask in masks:
        number, iou = share_owner(mask, wholes)
        shape = measure_shape(points, known, mask, float(frame[2, 3])) if mask.sum() >= MIN_PIXELS else None
        if shape is not None and not OTHER < iou < SAME:
            yield (name_kind(room.things[number - 2].solid.kind) if iou >= SAME else NONE), shape


def find_wholes(picture: Picture, room: Room) -> dict[int, list[Mask]]:
    """By its number what shows a thing: its pixels, and these with those of what it carries."""
    seen = [int(one) for one in np.unique(picture.owner) if BACKGROUND < one < NOTHING]
    wholes = {}
    for number in seen:
        alone = picture.owner == number
        carried = [one for one in seen if room.things[one - 2].support == number]
        wholes[number] = [alone, alone | np.isin(picture.owner, carried)] if carried else [alone]
    return wholes
