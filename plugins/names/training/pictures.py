"""Pictures of random rooms by rays: true depth, the owner of each pixel, and the level frame."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from plugins.names.training.rooms import FLOOR, WALL, Room, triangles
from plugins.names.training.solids import Array, Rng
from stages.geometry.cameras import look_at, make_intrinsics
from stages.geometry.planes import Plane
from stages.geometry.room_planes import make_floor_frame

WIDTH, HEIGHT = 320, 240  # pixels
GROUND, BACKGROUND, NOTHING = 0, 1, 255  # in `owner`; things are numbered from 2 on
TOP = 0.02  # metres within which a table's top is the ground
LEAST = 48  # pixels: what shows fewer is no thing to learn
TABLES = ("coffee_table", "table", "desk", "sideboard", "nightstand", "tv_stand", "bottom_cabinet", "chest_of_drawers")
AT_TABLE = 0.3  # share of pictures that look at a laid table, if there is one; chosen
NEAREST = 0.35  # metres: no picture shows a tenth of its pixels nearer; chosen


@dataclass(frozen=True)
class Picture:
    """depth (H, W) metres, 0: nothing; cosine (H, W) between ray and surface; owner (H, W) uint8; intrinsics (3, 3);
    frame (4, 4) floor_from_camera, z = 0: what things stand on."""

    depth: Array
    cosine: Array
    owner: NDArray[np.uint8]
    intrinsics: Array
    frame: Array


class Caster:
    """A room in Open3D's ray-casting scene."""

    def __init__(self, room: Room) -> None:
        vertices, faces, self.owner, self.mirrors = triangles(room)
        self.scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self.scene.add_triangles(o3d.core.Tensor.from_numpy(vertices), o3d.core.Tensor.from_numpy(faces))

    def cast(self, origins: Array, directions: Array) -> tuple[Array, Array, NDArray[np.int64], NDArray[np.bool_]]:
        """Length in `directions`, normal, owner, and whether it mirrors, of the first hit of rays (N, 3), (N, 3).

        Without a hit the length is 0 and the owner `NOTHING`.
        """
        rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
        found = self.scene.cast_rays(o3d.core.Tensor.from_numpy(rays))
        length = found["t_hit"].numpy().astype(float)
        there = np.isfinite(length)
        face = np.where(there, found["primitive_ids"].numpy(), 0).astype(int)
        owner = np.where(there, self.owner[face], NOTHING)
        normal = found["primitive_normals"].numpy().astype(float)
        return np.where(there, length, 0.0), normal, owner, self.mirrors[face] & there


def pictures_in(room: Room, views: int, rng: Rng) -> Iterator[Picture]:
    """At most `views` pictures of a room; an owner n of its pixels is `room.things[n - 2]`."""
    caster = Caster(room)
    for _ in range(views):
        picture = _look(caster, room, rng)
        if picture is not None:
            yield picture


def _look(caster: Caster, room: Room, rng: Rng) -> Picture | None:
    """A picture from a random place in the room; None: something is too near.

    Half of the sensors see through mirrors into the room behind.
    """
    eye, target, ground, carrier = _choose_view(room, rng)
    if np.linalg.norm((target - eye)[:2]) < 0.2 or (eye[:2] < 0.03).any() or (eye[:2] > room.size[:2] - 0.03).any():
        return None
    focal = WIDTH * np.exp(rng.uniform(np.log(0.6), np.log(1.25)))
    intrinsics = make_intrinsics(focal, focal, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    pose, roll = look_at(eye, target), rng.normal(0, 0.04)
    c, s = np.cos(roll), np.sin(roll)
    pose[:3, :3] = pose[:3, :3] @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    rows, columns = np.indices((HEIGHT, WIDTH))
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1).reshape(-1, 3)
    directions = pixels @ np.linalg.inv(intrinsics).T @ pose[:3, :3].T
    origins = np.broadcast_to(pose[:3, 3], directions.shape)
    depth, normal, owner, mirrors = caster.cast(origins, directions)
    if np.quantile(depth, 0.1) < NEAREST:
        return None
    heights = (origins + depth[:, None] * directions)[:, 2] - ground
    cosine = np.abs((directions * normal).sum(axis=1)) / np.linalg.norm(directions, axis=1)
    if rng.random() < 0.5:
        points, facing = (origins + depth[:, None] * directions)[mirrors], normal[mirrors]
        onward = directions[mirrors] - 2 * (directions[mirrors] * facing).sum(axis=1, keepdims=True) * facing
        depth[mirrors] += caster.cast(points + 1e-3 * onward, onward)[0]
    owner = _choose_owners(room, owner, carrier, np.abs(heights) < TOP)
    frame = make_floor_frame(Plane(pose[2, :3], ground - pose[2, 3], np.zeros(0, dtype=bool)))
    shape = HEIGHT, WIDTH
    shown = owner.astype(np.uint8).reshape(shape)
    return Picture(depth.reshape(shape), cosine.reshape(shape), shown, intrinsics, frame)


def _choose_view(room: Room, rng: Rng) -> tuple[Array, Array, float, int]:
    """Where the camera is and what it looks at, (3,) each; the height of what things stand on, and whose top it is."""
    tables = [k for k, thing in enumerate(room.things, 2) if thing.solid.kind in TABLES and thing.support == FLOOR]
    laid = [k for k in tables if any(thing.support == k for thing in room.things)]
    if laid and rng.random() < AT_TABLE:
        carrier = int(rng.choice(laid))
        table = room.things[carrier - 2]
        ground = float(table.position[2] + table.size[2])
        target = np.array([*table.position[:2], ground]) + rng.normal(0, [0.15, 0.15, 0.05])
        distance, down, around = rng.uniform(0.5, 1.6), rng.uniform(0.3, 1.15), rng.uniform(0, 2 * np.pi)
        flat = np.cos(down) * np.array([np.cos(around), np.sin(around)])
        return target + distance * np.array([*flat, np.sin(down)]), target, ground, carrier
    height = rng.choice([rng.uniform(0.5, 1.2), rng.normal(1.45, 0.2)])
    eye = np.array([*rng.uniform(0.06, 0.94, 2) * room.size[:2], height])
    spots = [np.array([*thing.position[:2], thing.position[2] + thing.size[2] / 2]) for thing in room.things]
    target = spots[int(rng.integers(len(spots)))] if spots else room.size / 2
    return eye, 0.7 * target + 0.3 * np.array([*room.size[:2] / 2, 0.8]), 0.0, FLOOR


def _choose_owners(room: Room, owner: NDArray[np.int64], carrier: int, level: NDArray[np.bool_]) -> NDArray[np.int64]:
    """`Picture.owner` (N,): beside a table whose top is the ground all that does not stand on it is background.

    `carrier`: FLOOR, or that table; `level`: (N,) pixels at the height of the ground.
    """
    shown = owner.copy()
    if carrier != FLOOR:
        root = np.arange(len(room.things) + 2)
        for number, thing in enumerate(room.things, 2):  # what carries stands before what it carries
            if thing.support == carrier:
                continue
            root[number] = root[thing.support] if thing.support not in (FLOOR, WALL) else WALL
        things = (owner > BACKGROUND) & (owner < NOTHING)
        shown[things] = np.where(root[owner[things]] == WALL, WALL, owner[things])
        shown[owner == FLOOR] = BACKGROUND
        shown[owner == carrier] = np.where(level[owner == carrier], GROUND, BACKGROUND)
    values, counts = np.unique(shown, return_counts=True)
    shown[np.isin(shown, values[(counts < LEAST) & (values > BACKGROUND)])] = NOTHING
    return shown
