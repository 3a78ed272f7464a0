"""Random rooms: rows along walls, tables with chairs, things on tops, what hangs; then more of every kind alike."""

from functools import cache

import numpy as np

from plugins.furniture.catalogue import CATEGORIES
from plugins.names.training.junk import JUNK, make_junk
from plugins.names.training.rooms import FLOOR, WALL, Placed, Room, build_shell, find_level_below, wall_point
from plugins.names.training.solids import OTHERS, Array, Rng, Solid, make_solid

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
# Kinds by where they stand; named twice: as often.
TALL = ("wardrobe", "bookshelf", "fridge", "floor_lamp", "plant_pot", "chest_of_drawers", "bookshelf", "curtain")
LOW = (
    *("sideboard", "tv_stand", "desk", "bed", "sofa", "armchair", "nightstand", "bench", "trash_can", "basket", "box"),
    *("ottoman", "radiator", "sink", "suitcase", "toilet", "bag"),
)
KITCHEN = ("bottom_cabinet", "oven", "dishwasher", "bottom_cabinet", "fridge", "washing_machine")
MIDDLE = (
    *("coffee_table", "table", "desk", "armchair", "sofa", "stool", "office_chair", "plant_pot", "basket", "heap"),
    *("ottoman", "bag", "suitcase"),
)
SEATS = ("chair", "chair", "chair", "stool", "office_chair", "bench")
SMALL = (
    *("book", "bottle", "bowl", "box", "candlestick", "clock", "cooking_pot", "jar", "kettle", "laptop", "microwave"),
    *("mug", "pan", "plant_pot", "plate", "table_lamp", "television", "toaster", "vase", "monitor", "keyboard", "heap"),
    *("heap", "heap", "sheet", "book", "mug", "basket", "cushion", "mouse", "telephone", "cell_phone", "remote", "can"),
    *("wine_glass", "cutlery"),
)
HANGING = ("picture", "picture", "picture", "mirror", "clock", "wall_cabinet", "wall_shelf", "television")
TOPS = {"curtain": 2.3, "radiator": 0.75, "sink": 0.95, "toilet": 0.45}  # metres: what hangs low ends there; chosen
MODELS = 2_000_003  # added to the seed: no library has the models of this one


@cache
def make_pool(models: int, seed: int) -> Pool:
    """So many solids of every category, of the further kinds of rooms, and of junk."""

    def make(kind: str, index: int) -> Solid:
        rng = np.random.default_rng(np.random.SeedSequence((seed + MODELS, *kind.encode(), index)))
        return make_junk(kind, rng) if kind in JUNK else make_solid(kind, rng, index)

    return {kind: [make(kind, index) for index in range(models)] for kind in (*CATEGORIES, *OTHERS, *JUNK)}


def furnish(pool: Pool, rng: Rng) -> Room:
    """A random room of solids out of the pool, with `MORE` further things, every kind as likely."""
    room = build_shell(rng)
    for side in range(4):
        if rng.random() < 0.75:
            _stand_along(room, side, pool, rng)
    for _ in range(int(rng.integers(0, 5))):
        _stand_in_the_middle(room, pool, rng)
    if rng.random() < 0.4:
        _lay_rug(room, pool, rng)
    for side in range(4):
        _hang(room, side, pool, rng)
    for owner in range(len(room.things)):
        _set_upon(room, owner, pool, rng)
    for kind in rng.choice(sorted(pool), MORE):
        for _ in range(TRIES):
            solid, scale = draw_scaled(str(kind), pool, rng, 0.1)
            new = _place(room, solid, scale, rng)
            base = None if new is None or new.support < 2 else room.things[new.support - 2]
            if new is not None and room.is_free(new, [thing for thing in room.things if thing is not base]):
                room.things.append(new)
                break
    return room


def draw_scaled(kind: str, pool: Pool, rng: Rng, spread: float = 0.12) -> tuple[Solid, Array]:
    """A solid of a kind and factors (3,) on its size; `spread`: of the logarithms, as a whole and of each side."""
    solids = pool[kind]
    whole = np.exp(rng.normal(0, spread))
    return solids[int(rng.integers(len(solids)))], whole * np.exp(rng.normal(0, spread, 3))


def _stand_along(room: Room, side: int, pool: Pool, rng: Rng) -> None:
    """A row at a wall: gaps between them or none."""
    length = room.size[side % 2]
    kinds = KITCHEN if rng.random() < 0.2 else (*TALL, *LOW)
    tight = kinds is KITCHEN or rng.random() < 0.2
    along = rng.uniform(0, 0.4 * length)
    while along < length:
        kind = str(rng.choice(kinds))
        solid, scale = draw_scaled(kind, pool, rng)
        deep, wide, _ = solid.size * scale
        bottom = max(0.0, TOPS.get(kind, 0.0) - solid.size[2] * scale[2])
        off = deep / 2 + (0.0 if tight or bottom else rng.uniform(0.0, 0.1))
        point, yaw = wall_point(room.size, side, along + wide / 2, off)
        turn = rng.normal(0, 0.15) if kind in ("armchair", "plant_pot", "heap") else 0.0
        support = WALL if bottom else FLOOR
        new = Placed(solid, scale, yaw + turn, np.array([*point, bottom]), support)
        if room.is_free(new, room.things):
            room.things.append(new)
            if kind == "desk":
                _seat(room, new, 0, pool, rng)
        along += wide + (0.005 if tight else rng.choice([0.01, rng.uniform(0.02, 0.8)]))


def _seat(room: Room, table: Placed, side: int, pool: Pool, rng: Rng) -> None:
    """A chair at one of a table's sides, pushed in or not."""
    solid, scale = draw_scaled(str(rng.choice(SEATS)), pool, rng, 0.07)
    angle = table.yaw + side * np.pi / 2
    half = table.size[side % 2] / 2
    off = half + solid.size[0] / 2 * rng.uniform(-0.3, 1.2)
    shift = rng.uniform(-0.35, 0.35) * table.size[1 - side % 2]
    out, along = (np.array([np.cos(t), np.sin(t)]) for t in (angle, angle + np.pi / 2))
    point = table.position[:2] + off * out + shift * along
    new = Placed(solid, scale, angle + np.pi + rng.normal(0, 0.25), np.array([*point, 0.0]), FLOOR)
    if room.is_free(new, [thing for thing in room.things if thing is not table]):
        room.things.append(new)


def _stand_in_the_middle(room: Room, pool: Pool, rng: Rng) -> None:
    for _ in range(4):
        kind = str(rng.choice(MIDDLE))
        solid, scale = draw_scaled(kind, pool, rng)
        yaw = rng.choice([0, 1, 2, 3]) * np.pi / 2 + rng.normal(0, 0.3)
        point = rng.uniform(0.2, 0.8, 2) * room.size[:2]
        new = Placed(solid, scale, yaw, np.array([*point, 0.0]), FLOOR)
        if room.is_free(new, room.things):
            room.things.append(new)
            if kind in ("table", "desk"):
                for side in rng.permutation([0, 1, 2, 3, 0, 2])[: int(rng.integers(0, 7))]:
                    _seat(room, new, int(side), pool, rng)
            return


def _lay_rug(room: Room, pool: Pool, rng: Rng) -> None:
    """A rug, beneath what stands there."""
    solid, scale = draw_scaled("rug", pool, rng)
    point = rng.uniform(0.3, 0.7, 2) * room.size[:2]
    new = Placed(solid, scale, rng.choice([0, 1]) * np.pi / 2 + rng.normal(0, 0.1), np.array([*point, 0.0]), FLOOR)
    if room.is_free(new, []):
        room.things.append(new)


def _hang(room: Room, side: int, pool: Pool, rng: Rng) -> None:
    """What hangs on a wall: one, a row or a group of pictures."""
    kind = str(rng.choice(HANGING))
    along = rng.uniform(0.1, 0.6) * room.size[side % 2]
    bottom = rng.uniform(1.0, 1.7)
    for _ in range(int(rng.choice([0, 1, 1, 1, 2, 3, 5]))):
        kind = kind if rng.random() < 0.7 else str(rng.choice(HANGING))
        solid, scale = draw_scaled(kind, pool, rng, 0.25)
        deep, wide, _ = solid.size * scale
        point, yaw = wall_point(room.size, side, along + wide / 2, deep / 2)
        new = Placed(solid, scale, yaw, np.array([*point, bottom + rng.normal(0, 0.05)]), WALL)
        if new.position[2] + new.size[2] < room.size[2] and room.is_free(new, room.things):
            room.things.append(new)
        along += wide + rng.choice([0.01, rng.uniform(0.03, 0.6)])


def _set_upon(room: Room, owner: int, pool: Pool, rng: Rng) -> None:
    """Small things on a thing's level places, alone, in heaps and stacks."""
    below = room.things[owner]
    if below.support == WALL and below.solid.kind not in ("wall_shelf", "wall_cabinet"):
        return
    if below.size[:2].min() < 0.18 or below.size[2] > 1.9:
        return
    area = below.size[0] * below.size[1]
    count = int(rng.poisson(rng.choice([0.0, 2.0, 5.0, 12.0]) * min(1.5, area)))
    soft = below.solid.kind in ("sofa", "bed", "armchair", "office_chair", "chair", "bench")
    mine: list[Placed] = []
    for _ in range(min(count, 14)):
        kind = "cushion" if soft and rng.random() < 0.6 else str(rng.choice(SMALL))
        solid, scale = draw_scaled(kind, pool, rng, 0.2)
        base, number = below, owner
        if mine and rng.random() < 0.15:  # a stack
            base = mine[int(rng.integers(len(mine)))]
            number = next(k for k, thing in enumerate(room.things) if thing is base)
        half = base.size[:2] / 2
        spot = rng.uniform(-0.9, 0.9, 2) * half
        turn = rng.uniform(0, 2 * np.pi) if rng.random() < 0.5 else base.yaw + rng.normal(0, 0.2)
        c, s = np.cos(base.yaw), np.sin(base.yaw)
        point = base.position[:2] + np.array([[c, -s], [s, c]]) @ spot
        new = Placed(solid, scale, turn, np.array([*point, 0.0]), number + 2)
        level = find_level_below(base, new)
        if level is None:
            continue
        new = Placed(solid, scale, turn, np.array([*point, level]), number + 2)
        if room.is_free(new, [thing for thing in room.things if thing is not base and thing is not below]):
            mine.append(new)
            room.things.append(new)


def _place(room: Room, solid: Solid, scale: Array, rng: Rng) -> Placed | None:
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


def _place_upon(room: Room, solid: Solid, scale: Array, rng: Rng) -> Placed | None:
    """A place on one of the things that may carry others."""
    carriers = [n for n, one in enumerate(room.things) if one.size[:2].min() > 0.3 and one.size[2] < 1.5]
    if not carriers:
        return None
    owner = int(rng.choice(carriers))
    base = room.things[owner]
    c, s = np.cos(base.yaw), np.sin(base.yaw)
    point = base.position[:2] + np.array([[c, -s], [s, c]]) @ (rng.uniform(-0.45, 0.45, 2) * base.size[:2])
    yaw = base.yaw + rng.normal(0, 0.4)
    level = find_level_below(base, Placed(solid, scale, yaw, np.array([*point, 0.0]), owner + 2))
    return None if level is None else Placed(solid, scale, yaw, np.array([*point, level]), owner + 2)
