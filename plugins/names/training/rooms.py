"""A room of boxes with things in it: walls with doors and windows, what is free, what carries, and its triangles."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plugins.furniture.shapes import CUBE
from plugins.names.training.solids import CELLS, Array, Rng, Solid
from stages.geometry.frames import yaw_matrix

FLAT = 0.025  # metres by which what a thing stands on may be uneven
FLOOR, WALL = 0, 1  # owners; things are numbered from 2 on
BEYOND = 4.0  # metres that floor and ceiling go on behind doors and windows


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


def build_shell(rng: Rng) -> Room:
    """An empty room of random size."""
    size = np.array([*rng.uniform(2.4, 7.0, 2), rng.uniform(2.3, 3.2)])
    floor = np.array([[-BEYOND, -BEYOND, -0.1], [*size[:2] + BEYOND, 0.0]])
    ceiling = np.array([[-BEYOND, -BEYOND, size[2]], [*size[:2] + BEYOND, size[2] + 0.1]])
    return Room(size, [floor, ceiling, *(box for side in range(4) for box in _wall(size, side, rng))])


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


def triangles(room: Room) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int64], NDArray[np.bool_]]:
    """Vertices (V, 3), faces (F, 3), owner (F,), and whether they mirror (F,)."""
    vertices, faces, owners, mirrors, start = [], [], [], [], 0
    for number, (low, high) in enumerate(room.shell):
        vertices.append((low + high) / 2 + CUBE.vertices * (high - low))
        faces.append(CUBE.faces + start)
        owners.append(np.full(len(CUBE.faces), WALL if number else FLOOR))
        mirrors.append(np.zeros(len(CUBE.faces), dtype=bool))
        start += len(CUBE.vertices)
    for owner, thing in enumerate(room.things, 2):
        vertices.append(thing.vertices)
        faces.append(thing.solid.faces + start)
        owners.append(np.full(len(thing.solid.faces), owner))
        mirrors.append(thing.solid.mirrors)
        start += len(thing.solid.vertices)
    joined = [np.concatenate(each) for each in (vertices, faces, owners, mirrors)]
    return joined[0].astype(np.float32), joined[1].astype(np.uint32), joined[2], joined[3]
