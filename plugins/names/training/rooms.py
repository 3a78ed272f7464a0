"""Random rooms with a few things more, of every category alike and of none."""

from functools import cache

import numpy as np

from plugins.names.training.junk import JUNK, make_junk
from plugins.segmenter.training import rooms
from plugins.segmenter.training.kinds import SMALL, TOPS
from plugins.segmenter.training.pictures import MODELS, make_pool
from plugins.segmenter.training.rooms import FLOOR, WALL, Placed, Room, draw_scaled, wall_point
from plugins.segmenter.training.solids import Rng, Solid

Pool = dict[str, list[Solid]]
# What hangs, and metres between which its foot is; chosen. Beside it hangs what has its top at `TOPS`.
HUNG = {
    "a_door": (0.0, 0.01), "a_window": (0.6, 1.2), "clock": (1.2, 2.0), "mirror": (0.1, 1.6), "picture": (0.7, 1.9),
    "television": (0.6, 1.4), "wall_cabinet": (1.1, 1.6), "wall_shelf": (0.6, 1.9),
}  # fmt: skip
AGAINST_WALL = 0.6  # share of large things on the floor that stand with their back to a wall; chosen
LITTLE = 0.5  # metres: junk that is smaller stands on others, as what is in `SMALL` does; chosen
ON_FLOOR = 0.2  # share of small things that lie on the floor all the same; chosen
MORE, TRIES = 24, 4  # things more in a room, and places that are tried for one


@cache
def make_full_pool(models: int, seed: int) -> Pool:
    """So many solids of every category, of further kinds of the segmenter, and of junk."""

    def make(kind: str, index: int) -> Solid:
        return make_junk(kind, np.random.default_rng(np.random.SeedSequence((seed + MODELS, *kind.encode(), index))))

    return make_pool(models, seed) | {kind: [make(kind, index) for index in range(models)] for kind in JUNK}


def furnish_fully(pool: Pool, rng: Rng) -> Room:
    """A random room with `MORE` further things, every kind as likely."""
    room = rooms.furnish(pool, rng)
    for kind in rng.choice(sorted(pool), MORE):
        for _ in range(TRIES):
            solid, scale = draw_scaled(str(kind), pool, rng, 0.1)
            new = _place(room, solid, scale, rng)
            base = None if new is None or new.support < 2 else room.things[new.support - 2]
            if new is not None and room.is_free(new, [thing for thing in room.things if thing is not base]):
                room.things.append(new)
                break
    return room


def _place(room: Room, solid: Solid, scale: np.ndarray, rng: Rng) -> Placed | None:
    """A place for a thing, where such things are; None: there is none."""
    size, side = solid.size * scale, int(rng.integers(4))
    along = rng.uniform(size[1] / 2, max(size[1] / 2, room.size[side % 2] - size[1] / 2))
    if solid.kind in HUNG or solid.kind in TOPS:
        top = TOPS.get(solid.kind, 0.0) * rng.uniform(0.9, 1.15)
        foot = rng.uniform(*HUNG[solid.kind]) if solid.kind in HUNG else max(0.0, top - size[2])
        point, yaw = wall_point(room.size, side, along, size[0] / 2)
        return Placed(solid, scale, yaw, np.array([*point, foot]), WALL) if foot + size[2] < room.size[2] else None
    little = solid.kind in SMALL or (solid.kind in JUNK and size.max() < LITTLE)
    if little and rng.random() > ON_FLOOR:
        return _place_upon(room, solid, scale, rng)
    if rng.random() < AGAINST_WALL:
        point, yaw = wall_point(room.size, side, along, size[0] / 2 + rng.choice([0.0, rng.uniform(0, 0.15)]))
        return Placed(solid, scale, yaw, np.array([*point, 0.0]), FLOOR)
    point = rng.uniform(0.1, 0.9, 2) * room.size[:2]
    return Placed(solid, scale, rng.uniform(0, 2 * np.pi), np.array([*point, 0.0]), FLOOR)


def _place_upon(room: Room, solid: Solid, scale: np.ndarray, rng: Rng) -> Placed | None:
    """A place on one of the things that may carry others."""
    carriers = [n for n, one in enumerate(room.things) if one.size[:2].min() > 0.3 and one.size[2] < 1.5]
    if not carriers:
        return None
    owner = int(rng.choice(carriers))
    base = room.things[owner]
    c, s = np.cos(base.yaw), np.sin(base.yaw)
    point = base.position[:2] + np.array([[c, -s], [s, c]]) @ (rng.uniform(-0.45, 0.45, 2) * base.size[:2])
    yaw = base.yaw + rng.normal(0, 0.4)
    level = rooms.find_level_below(base, Placed(solid, scale, yaw, np.array([*point, 0.0]), owner + 2))
    return None if level is None else Placed(solid, scale, yaw, np.array([*point, level]), owner + 2)
