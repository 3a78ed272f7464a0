"""Ray-cast views of a random room: depth, owners and colours."""

from dataclasses import dataclass

import cv2
import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from plugins.furniture.textures import SIDE
from plugins.segmenter.training.rooms import FLOOR, Room, triangles
from plugins.segmenter.training.solids import Array, Rng, pattern_table
from stages.geometry.cameras import look_at

VOID = 65535  # owner of nothing
TABLES = ("coffee_table", "table", "desk", "sideboard", "nightstand", "tv_stand", "bottom_cabinet", "chest_of_drawers")


@dataclass(frozen=True)
class Seen:
    """What a camera sees.

    Attributes:
        depth: (H, W) metres along the axis, 0: nothing.
        cosine: (H, W) between ray and surface.
        beyond: (H, W) depth that a sensor may see in a mirror.
        owner: (H, W) see `rooms`; VOID: nothing.
        rgb: (H, W, 3) 0 to 1.
        intrinsics: (3, 3) pixels.
        pose: (4, 4) world_from_camera.
        ground: height of what things stand on, metres.
        ground_owner: FLOOR, or the table.
    """

    depth: Array
    cosine: Array
    beyond: Array
    owner: NDArray[np.int64]
    rgb: Array
    intrinsics: Array
    pose: Array
    ground: float
    ground_owner: int


class Caster:
    """A room in Open3D's ray-casting scene, with randomly drawn colours."""

    def __init__(self, room: Room, rng: Rng) -> None:
        self.room = room
        vertices, self.faces, self.owner, part = triangles(room)
        self.scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self.scene.add_triangles(o3d.core.Tensor.from_numpy(vertices), o3d.core.Tensor.from_numpy(self.faces))
        shell = len(room.shell)
        counts = [shell, *(len(thing.solid.colours) for thing in room.things)]
        start = np.concatenate([[0], np.cumsum(counts)])
        self.part = part + start[np.maximum(self.owner - 1, 0)]
        self.colour, self.pattern, self.repeat, self.painting = _draw_looks(room, rng)
        self.mirror = np.zeros(start[-1], dtype=bool)
        for number, thing in enumerate(room.things, 1):
            if thing.solid.mirror >= 0:
                self.mirror[start[number] + thing.solid.mirror] = True
        self.paintings = np.stack([draw_painting(rng) for _ in range(4)])
        self.light = _light(room, rng)

    def hits(self, origins: Array, directions: Array) -> dict[str, NDArray]:  # type: ignore[type-arg]
        """Length in `directions`, normal, part and owner of the first hit of rays (N, 3), (N, 3); length 0: none."""
        rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
        found = self.scene.cast_rays(o3d.core.Tensor.from_numpy(rays))
        length = found["t_hit"].numpy()
        there = np.isfinite(length)
        face = np.where(there, found["primitive_ids"].numpy(), 0).astype(int)
        return {
            "length": np.where(there, length, 0.0),
            "normal": found["primitive_normals"].numpy(),
            "part": self.part[face],
            "owner": np.where(there, self.owner[face], VOID),
        }

    def shade(self, found: dict[str, NDArray], points: Array, directions: Array) -> Array:  # type: ignore[type-arg]
        """Colours (N, 3) of hits at points (N, 3)."""
        part, normal = found["part"], found["normal"]
        axis = np.abs(normal).argmax(axis=1)
        one = np.where(axis == 0, points[:, 1], points[:, 0])
        two = np.where(axis == 2, points[:, 1], points[:, 2])
        scale = self.repeat[part]
        u, v = (np.floor(SIDE * c / scale).astype(int) % SIDE for c in (one, two))
        colour = self.colour[part] * pattern_table()[self.pattern[part], v, u][:, None]
        for number in np.unique(self.painting[part]):
            if number >= 0:
                self._paint(colour, part, found["owner"], points, number)
        ambient, lamp, strength = self.light
        towards = lamp - points
        distance = np.linalg.norm(towards, axis=1, keepdims=True) + 1e-3
        facing = normal * np.where((normal * directions).sum(axis=1) > 0, -1.0, 1.0)[:, None]
        lit = np.maximum((facing * towards).sum(axis=1, keepdims=True) / distance, 0) / (0.3 + 0.15 * distance**2)
        return np.asarray(colour * (ambient * (0.75 + 0.25 * facing[:, 2:]) + strength * lit))

    def _paint(
        self, colour: Array, part: NDArray[np.int64], owner: NDArray[np.int64], points: Array, number: int
    ) -> None:
        """A picture over the surface of a thing that hangs, or a screen."""
        at = np.flatnonzero(self.painting[part] == number)
        for one in np.unique(owner[at]):
            mine = at[owner[at] == one]
            if one < 2 or one == VOID:
                continue
            thing = self.room.things[one - 2]
            across = thing.local(points[mine, :2])[:, 1] / thing.size[1] + 0.5
            up = (points[mine, 2] - thing.position[2]) / thing.size[2]
            canvas = self.paintings[number]
            rows, columns = ((c.clip(0, 0.999) * len(canvas)).astype(int) for c in (1 - up, across))
            colour[mine] = canvas[rows, columns]


def _draw_looks(room: Room, rng: Rng) -> tuple[Array, NDArray[np.int64], Array, NDArray[np.int64]]:
    """Colour, pattern, its repeat, and painting of every part: mostly as they are made, else plain or at random."""
    patterns = len(pattern_table())
    count = len(room.shell)
    base = rng.uniform(0.35, 0.95) + rng.normal(0, 0.07, 3)
    colour = [base + rng.normal(0, 0.01, (count, 3))]
    colour[0][0] = rng.uniform(0.15, 0.8) * (1 + rng.uniform(-0.3, 0.3, 3))
    colour[0][1] = rng.uniform(0.7, 1.0)
    pattern = [np.where(rng.random(count) < 0.15, rng.integers(0, patterns, count), 0)]
    pattern[0][2:] = pattern[0][2] if count > 2 else 0
    pattern[0][0] = rng.integers(0, patterns) if rng.random() < 0.7 else 0
    repeat, painted = [rng.uniform(0.3, 2.5, count)], [np.full(count, -1)]
    for thing in room.things:
        solid = thing.solid
        parts = len(solid.colours)
        mode = rng.random()
        own = solid.colours if mode < 0.5 else np.tile(rng.uniform(0.05, 0.95) + rng.normal(0, 0.12, 3), (parts, 1))
        if 0.5 < mode < 0.6 or (thing.support == FLOOR and rng.random() < 0.05):
            own = np.tile(base + rng.normal(0, 0.04, 3), (parts, 1))  # as the walls
        colour.append(own * (1 + rng.normal(0, 0.05, (parts, 1))))
        pattern.append(solid.patterns if mode < 0.75 else np.full(parts, rng.integers(0, patterns)))
        repeat.append(solid.repeat)
        pictured = {"picture": 0.85, "television": 0.3, "monitor": 0.5, "book": 0.2, "box": 0.15}.get(solid.kind, 0.02)
        painted.append(np.full(parts, int(rng.integers(4)) if rng.random() < pictured else -1))
    joined = np.concatenate(colour).clip(0.01, 1.0)
    return joined, np.concatenate(pattern), np.concatenate(repeat), np.concatenate(painted)


def draw_painting(rng: Rng) -> Array:
    """A picture (64, 64, 3): blots, bars and rings of some colours, at times on white with a frame."""
    canvas = np.tile(rng.uniform(0, 1, 3), (64, 64, 1))
    canvas += rng.uniform(-0.3, 0.3, 3) * np.linspace(-1, 1, 64)[:, None, None]
    palette = rng.uniform(0, 1, (4, 3))
    for _ in range(int(rng.integers(0, 14))):
        x, y, w, h = (int(c) for c in rng.integers([0, 0, 2, 2], [64, 64, 40, 40]))
        ink = palette[int(rng.integers(4))].tolist()
        if rng.random() < 0.5:
            cv2.ellipse(canvas, (x, y), (w // 2, h // 2), float(rng.uniform(0, 180)), 0, 360, ink, -1)
        else:
            cv2.rectangle(canvas, (x, y), (x + w, y + h), ink, -1)
    if rng.random() < 0.5:
        canvas = canvas + rng.normal(0, 0.15, (64, 64, 1)) * rng.random()
    edge = int(rng.integers(0, 9))
    if edge:
        canvas[:edge], canvas[-edge:], canvas[:, :edge], canvas[:, -edge:] = [rng.uniform(0, 1)] * 4
    return np.asarray(cv2.GaussianBlur(canvas, (0, 0), rng.uniform(0.3, 1.5)).clip(0, 1))


def _light(room: Room, rng: Rng) -> tuple[Array, Array, Array]:
    tint = 1 + rng.normal(0, 0.06, 3)
    lamp = room.size * rng.uniform([0.05, 0.05, 0.5], [0.95, 0.95, 0.98])
    return rng.uniform(0.25, 0.8) * tint, lamp, rng.uniform(0.2, 1.2) * (1 + rng.normal(0, 0.06, 3))


def look(caster: Caster, width: int, height: int, rng: Rng, coloured: bool = True) -> Seen | None:
    """A picture from a random place in the room, one in four of a table top; None: something is too near.

    Without colours, which take half of the time, its `rgb` is black.
    """
    room = caster.room
    tables = [k for k, thing in enumerate(room.things) if thing.solid.kind in TABLES and thing.support == FLOOR]
    laid = [k for k in tables if any(thing.support == k + 2 for thing in room.things)]
    ground, owner = 0.0, FLOOR
    if laid and rng.random() < 0.3:
        owner = int(rng.choice(laid)) + 2
        table = room.things[owner - 2]
        ground = float(table.position[2] + table.size[2])
        target = np.array([*table.position[:2], ground]) + rng.normal(0, [0.15, 0.15, 0.05])
        distance, down, around = rng.uniform(0.5, 1.6), rng.uniform(0.3, 1.15), rng.uniform(0, 2 * np.pi)
        flat = np.array([np.cos(around), np.sin(around)])
        eye = target + distance * np.array([*np.cos(down) * flat, np.sin(down)])
    else:
        eye = np.array(
            [*rng.uniform(0.06, 0.94, 2) * room.size[:2], rng.choice([rng.uniform(0.5, 1.2), rng.normal(1.45, 0.2)])]
        )
        spots = [np.array([*thing.position[:2], thing.position[2] + thing.size[2] / 2]) for thing in room.things]
        target = spots[int(rng.integers(len(spots)))] if spots else room.size / 2
        target = 0.7 * target + 0.3 * np.array([*room.size[:2] / 2, 0.8])
    if np.linalg.norm((target - eye)[:2]) < 0.2 or (eye[:2] < 0.03).any() or (eye[:2] > room.size[:2] - 0.03).any():
        return None
    focal = width * np.exp(rng.uniform(np.log(0.6), np.log(1.25)))
    intrinsics = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    pose = look_at(eye, target)
    roll = rng.normal(0, 0.04)
    c, s = np.cos(roll), np.sin(roll)
    pose[:3, :3] = pose[:3, :3] @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    rows, columns = np.indices((height, width))
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1).reshape(-1, 3)
    directions = pixels @ np.linalg.inv(intrinsics).T @ pose[:3, :3].T
    origins = np.broadcast_to(pose[:3, 3], directions.shape)
    found = caster.hits(origins, directions)
    depth = found["length"].astype(float)
    if np.quantile(depth, 0.1) < 0.35:
        return None
    points = origins + depth[:, None] * directions
    rgb = caster.shade(found, points, directions) if coloured else np.zeros_like(points)
    rgb[found["owner"] == VOID] = rng.uniform(0.5, 1.0)
    beyond = depth.copy()
    glass = np.flatnonzero(caster.mirror[found["part"]] & (found["owner"] != VOID))
    if len(glass):
        normal = found["normal"][glass]
        onward = directions[glass] - 2 * (directions[glass] * normal).sum(axis=1, keepdims=True) * normal
        shown = caster.hits(points[glass] + 1e-3 * onward, onward)
        beyond[glass] += shown["length"]
        if coloured:
            rgb[glass] = caster.shade(shown, points[glass] + shown["length"][:, None] * onward, onward)
    cosine = np.abs((directions * found["normal"]).sum(axis=1)) / np.linalg.norm(directions, axis=1)
    shape = (height, width)
    return Seen(
        depth.reshape(shape), cosine.reshape(shape), beyond.reshape(shape), found["owner"].reshape(shape),
        rgb.clip(0, 1.5).reshape(*shape, 3), intrinsics, pose, ground, owner,
    )  # fmt: skip
