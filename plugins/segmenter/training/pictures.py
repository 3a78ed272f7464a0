"""Pictures of random rooms: true depth, colour, the owner of each pixel, and the level frame."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plugins.furniture.catalogue import CATEGORIES
from plugins.segmenter.training.rooms import FLOOR, WALL, Room, furnish
from plugins.segmenter.training.solids import OTHERS, Rng, Solid, make_solid
from plugins.segmenter.training.views import VOID, Caster, Seen, look
from stages.geometry.frames import apply
from stages.geometry.planes import Plane
from stages.geometry.room_planes import make_floor_frame

SMALL, LARGE = (160, 120), (320, 240)  # width and height in pixels
GROUND, BACKGROUND, NOTHING = 0, 1, 255  # in `owner`; things are numbered from 2 on
TOP = 0.02  # metres within which a table's top is the ground
LEAST = 12  # pixels of a small picture; what shows fewer is no thing to learn
MODELS = 2_000_003  # added to the seed: no library has the models of this one


@dataclass(frozen=True)
class Picture:
    """depth (H, W) float32 metres, 0: nothing; cosine (H, W) uint8, 255: seen straight on; owner (H, W) uint8;
    rgb (H, W, 3) uint8; intrinsics (3, 3); frame (4, 4) floor_from_camera, z = 0: what things stand on."""

    depth: NDArray[np.float32]
    cosine: NDArray[np.uint8]
    owner: NDArray[np.uint8]
    rgb: NDArray[np.uint8]
    intrinsics: NDArray[np.float64]
    frame: NDArray[np.float64]


def make_pool(models: int, seed: int) -> dict[str, list[Solid]]:
    """Make `count` solids of every kind."""

    def make(kind: str, index: int) -> Solid:
        rng = np.random.default_rng(np.random.SeedSequence((seed + MODELS, *kind.encode(), index)))
        return make_solid(kind, rng, index)

    return {kind: [make(kind, index) for index in range(models)] for kind in (*CATEGORIES, *OTHERS)}


def views_of(pool: dict[str, list[Solid]], size: tuple[int, int], views: int, rng: Rng) -> Iterator[Picture]:
    """At most `views` pictures of one random room."""
    return pictures_in(furnish(pool, rng), size, views, rng)


def pictures_in(room: Room, size: tuple[int, int], views: int, rng: Rng, coloured: bool = True) -> Iterator[Picture]:
    """At most `views` pictures of a room; an owner n of its pixels is `room.things[n - 2]`."""
    caster = Caster(room, rng)
    for _ in range(views):
        seen = look(caster, *size, rng, coloured)
        if seen is not None:
            yield _picture(room, seen, rng)


def _picture(room: Room, seen: Seen, rng: Rng) -> Picture:
    up = seen.pose[2, :3]  # the room's z in the camera frame
    frame = make_floor_frame(Plane(up, seen.ground - seen.pose[2, 3], np.zeros(0, dtype=bool)))
    mirrored = seen.beyond != seen.depth
    depth = np.where(mirrored & (rng.random() < 0.5), seen.beyond, seen.depth)
    return Picture(
        depth.astype(np.float32),
        np.rint(255 * seen.cosine).astype(np.uint8),
        _owners(room, seen),
        np.rint(255 * seen.rgb.clip(0, 1)).astype(np.uint8),
        seen.intrinsics,
        frame,
    )


def _owners(room: Room, seen: Seen) -> NDArray[np.uint8]:
    """`Picture.owner`: beside a table whose top is the ground all that does not stand on it is background."""
    root = np.arange(len(room.things) + 2)
    for owner, thing in enumerate(room.things, 2):  # what carries stands before what it carries
        root[owner] = root[thing.support] if thing.support not in (FLOOR, WALL, seen.ground_owner) else owner
        if seen.ground_owner != FLOOR and thing.support != seen.ground_owner and root[owner] == owner:
            root[owner] = WALL
    kept = np.append(root, NOTHING)
    kept[2:-1] = np.where(root[2:] == WALL, WALL, np.arange(2, len(root)))
    whose: NDArray[np.int64] = kept[np.where(seen.owner == VOID, len(root), seen.owner)]
    if seen.ground_owner != FLOOR:
        whose[seen.owner == FLOOR] = BACKGROUND
        whose[seen.owner == seen.ground_owner] = BACKGROUND
        rows, columns = np.nonzero(seen.owner == seen.ground_owner)
        rays = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ np.linalg.inv(seen.intrinsics).T
        height = apply(seen.pose, rays * seen.depth[rows, columns, None])[:, 2] - seen.ground
        top = np.abs(height) < TOP
        whose[rows[top], columns[top]] = GROUND
    least = LEAST * whose.size / (SMALL[0] * SMALL[1])
    values, counts = np.unique(whose, return_counts=True)
    whose[np.isin(whose, values[(counts < least) & (values > BACKGROUND)])] = NOTHING
    return whose.astype(np.uint8)


def draw_pictures(
    pool: dict[str, list[Solid]], count: int, size: tuple[int, int], views: int, rng: Rng
) -> list[Picture]:
    """Draw `count` pictures, at most `views` of a room."""
    drawn: list[Picture] = []
    while len(drawn) < count:
        drawn += views_of(pool, size, min(views, count - len(drawn)), rng)
    return drawn
