"""Random rooms: rows along walls, tables with chairs, things on tops, what hangs; walls with doors and windows."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plugins.furniture.shapes import CUBE
from plugins.segmenter.training.kinds import HANGING, KITCHEN, LOW, MIDDLE, SEATS, SMALL, TALL, TOPS
from plugins.segmenter.training.solids import CELLS, Array, Rng, Solid
from stages.geometry.frames import yaw_matrix

FLAT = 0.025  # metres by which what a thing stands on may be uneven
FLOOR, WALL = 0, 1  # owners; things are numbered from 2 on


@dataclass(frozen=True)
class Placed:
    """A solid stretched by `scale` (3,), turned by `yaw`, its base at `position`; on the floor, a wall or a thing."""

    solid: Solid
    scale: Array
    yaw: float
    position: Array
    support: int  # FLOOR, WALL, or an owner

    @property
    def size(self) -> Array:
        """(3,) metres, unturned."""
        return self.solid.size * self.scale

    @property
    def vertices(self) -> Array:
        """(V, 3) in the room."""
        return self.solid.vertices * self.scale @ yaw_matrix(self.yaw).T + self.position

    def local(self, points: Array) -> Array:
        """Points (N, 2) of the room in the thing's axes."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return np.asarray((points - self.position[:2]) @ np.array([[c, -s], [s, c]]))

    def corners(self, margin: float = 0.0) -> Array:
        """(4, 2) of its box from above."""
        half = self.size[:2] / 2 + margin
        turn = yaw_matrix(self.yaw)[:2, :2]
        return np.asarray(np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * half @ turn.T + self.position[:2])


@dataclass
class Room:
    """`size` (3,) metres, corner at the origin; boxes (N, 2, 3) of floor (the first), ceiling and walls; the things."""

    size: Array
    shell: list[Array]
    things: list[Placed] = field(default_factory=list)

    def is_free(self, new: Placed, others: Sequence[Placed]) -> bool:
        """Whether a new thing overlaps no wall and no other thing at its height, by their boxes from above."""
        corners = new.corners()
        if (corners < -1e-6).any() or (corners > self.size[:2] + 1e-6).any():
            return False
        low, high = new.position[2], new.position[2] + new.size[2]
        level = [o for o in others if o.position[2] < high - 0.01 and o.position[2] + o.size[2] > low + 0.01]
        return not any(_overlap(corners, other.corners()) for other in level)


def _overlap(a: Array, b: Array) -> bool:
    """Whether two rectangles (4, 2) overlap, by separating axes."""
    for shape in (a, b):
        for axis in (shape[1] - shape[0], shape[2] - shape[1]):
            first, second = a @ axis, b @ axis
            if first.max() <= second.min() or second.max() <= first.min():
                return False
    return True


def furnish(pool: dict[str, list[Solid]], rng: Rng) -> Room:
    """A random room of solids out of the pool."""
    size = np.array([*rng.uniform(2.4, 7.0, 2), rng.uniform(2.3, 3.2)])
    room = Room(size, [])
    for side in range(4):
        room.shell += _wall(size, side, rng)
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
    beyond = 4.0
    floor = np.array([[-beyond, -beyond, -0.1], [*size[:2] + beyond, 0.0]])
    ceiling = np.array([[-beyond, -beyond, size[2]], [*size[:2] + beyond, size[2] + 0.1]])
    room.shell = [floor, ceiling, *room.shell]
    return room


def _wall(size: Array, side: int, rng: Rng) -> list[Array]:
    """Boxes (2, 3) of one wall, with a door or window in it at times, and what is behind that; alcoves, pillars."""
    length, thick = size[side % 2], 0.15
    pieces = [(0.0, length, 0.0, size[2])]
    kind = rng.choice(["closed", "window", "door"], p=[0.5, 0.25, 0.25])
    if kind != "closed" and length > 2.2:
        wide = rng.uniform(0.8, 1.9) if kind == "window" else rng.uniform(0.75, 1.4)
        low, high = (rng.uniform(0.6, 1.1), rng.uniform(1.9, 2.2)) if kind == "window" else (0.0, rng.uniform(2.0, 2.2))
        start = rng.uniform(0.2, length - wide - 0.2)
        pieces = [
            (0.0, start, 0.0, size[2]),
            (start + wide, length, 0.0, size[2]),
            (start, start + wide, high, size[2]),
        ]
        if low:
            pieces.append((start, start + wide, 0.0, low))
    boxes = [_place_along(size, side, start, end, -thick, 0.0, low, high) for start, end, low, high in pieces]
    if kind == "door" or (kind == "window" and rng.random() < 0.5):
        gap = rng.uniform(0.8, 3.0)
        boxes.append(_place_along(size, side, -2.0, length + 2.0, -gap - 0.1, -gap, 0.0, size[2]))
    if rng.random() < 0.2:  # a pillar, a chimney, a radiator's cover
        start, wide, deep = rng.uniform(0, 0.8 * length), rng.uniform(0.2, 0.9), rng.uniform(0.05, 0.4)
        boxes.append(_place_along(size, side, start, min(length, start + wide), 0.0, deep, 0.0, size[2]))
    if rng.random() < 0.3:  # skirting
        boxes.append(_place_along(size, side, 0.0, length, 0.0, 0.015, 0.0, rng.uniform(0.05, 0.12)))
    return boxes


def _place_along(
    size: Array, side: int, start: float, end: float, near: float, far: float, low: float, high: float
) -> Array:
    """A box (2, 3) from `start` to `end` along a wall and from `near` to `far` into the room."""
    across = (near, far) if side < 2 else (size[1 - side % 2] - far, size[1 - side % 2] - near)
    ends = [(start, end), across] if side % 2 == 0 else [across, (start, end)]
    return np.array([[ends[0][0], ends[1][0], low], [ends[0][1], ends[1][1], high]])


def wall_point(size: Array, side: int, along: float, off: float) -> tuple[Array, float]:
    """A point (2,) `off` a wall into the room, and the yaw that looks away from the wall."""
    into = off if side < 2 else size[1 - side % 2] - off
    point = np.array([along, into] if side % 2 == 0 else [into, along])
    yaw = [np.pi / 2, 0.0, -np.pi / 2, np.pi][side]
    return point, yaw


def draw_scaled(kind: str, pool: dict[str, list[Solid]], rng: Rng, spread: float = 0.12) -> tuple[Solid, Array]:
    """A solid of a kind and factors (3,) on its size; `spread`: of the logarithms, as a whole and of each side."""
    solids = pool[kind]
    whole = np.exp(rng.normal(0, spread))
    return solids[int(rng.integers(len(solids)))], whole * np.exp(rng.normal(0, spread, 3))


def _stand_along(room: Room, side: int, pool: dict[str, list[Solid]], rng: Rng) -> None:
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


def _seat(room: Room, table: Placed, side: int, pool: dict[str, list[Solid]], rng: Rng) -> None:
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


def _stand_in_the_middle(room: Room, pool: dict[str, list[Solid]], rng: Rng) -> None:
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


def _lay_rug(room: Room, pool: dict[str, list[Solid]], rng: Rng) -> None:
    """A rug, beneath what stands there."""
    solid, scale = draw_scaled("rug", pool, rng)
    point = rng.uniform(0.3, 0.7, 2) * room.size[:2]
    new = Placed(solid, scale, rng.choice([0, 1]) * np.pi / 2 + rng.normal(0, 0.1), np.array([*point, 0.0]), FLOOR)
    if room.is_free(new, []):
        room.things.append(new)


def _hang(room: Room, side: int, pool: dict[str, list[Solid]], rng: Rng) -> None:
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


def _set_upon(room: Room, owner: int, pool: dict[str, list[Solid]], rng: Rng) -> None:
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


def find_level_below(base: Placed, new: Placed) -> float | None:
    """The height at which the base carries a new thing; None: it does not lie flat there."""
    inner = new.corners(-0.25 * float(new.size[:2].min()))
    mesh = np.concatenate([inner, inner.mean(axis=0, keepdims=True)])
    cells = np.floor((base.local(mesh) / base.size[:2] + 0.5) * CELLS).astype(int)
    if (cells < 0).any() or (cells >= CELLS).any():
        return None
    heights = base.solid.heights[cells[:, 0], cells[:, 1]] * base.scale[2]
    if not np.isfinite(heights).all() or np.ptp(heights) > FLAT:
        return None
    return float(base.position[2] + heights.max())


def triangles(room: Room) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int64], NDArray[np.int64]]:
    """Vertices (V, 3), faces (F, 3), owner (F,), and part (F,) of its owner (of the shell: which box)."""
    vertices, faces, owners, parts, start = [], [], [], [], 0
    for number, (low, high) in enumerate(room.shell):
        vertices.append((low + high) / 2 + CUBE.vertices * (high - low))
        faces.append(CUBE.faces + start)
        owners.append(np.full(len(CUBE.faces), WALL if number else FLOOR))
        parts.append(np.full(len(CUBE.faces), number))
        start += len(CUBE.vertices)
    for owner, thing in enumerate(room.things, 2):
        vertices.append(thing.vertices)
        faces.append(thing.solid.faces + start)
        owners.append(np.full(len(thing.solid.faces), owner))
        parts.append(thing.solid.part)
        start += len(thing.solid.vertices)
    joined = [np.concatenate(each) for each in (vertices, faces, owners, parts)]
    return joined[0].astype(np.float32), joined[1].astype(np.uint32), joined[2], joined[3]
