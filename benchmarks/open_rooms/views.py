"""What a camera truly sees of a room: depth, whose pixel it is, what shows in mirrors and through glass."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from benchmarks.open_rooms.packs import PackModel, PaintedMesh
from benchmarks.open_rooms.rooms import HEIGHT, WALLS, OpenRoom, PlacedModel
from benchmarks.open_rooms.sensor import DARK, GLASS, MATT, MIRROR, Floats, SensorView
from roomkin.stages.geometry import frames
from roomkin.stages.geometry.frames import make_transform, yaw_matrix

WIDTH, HEIGHT_PX = 640, 480
SCREENS = {"tv", "computer", "laptop"}
CLEAR = 0.45  # opacity below which a part counts as glass
MOST_LAYERS = 4  # see-through leaves and panes that a ray passes
OFF = 1e-4


@dataclass(frozen=True)
class PlacedMesh:
    """A part in the room, of the thing with number `owner` (0: the room itself)."""

    part: PaintedMesh
    owner: int
    kind: int


def look_at(eye: Sequence[float], look: Sequence[float], roll: float = 0.0) -> NDArray[np.float64]:
    """world_from_camera (4, 4) of a camera, x right, y down, z forward; `roll` radians clockwise."""
    return frames.look_at(eye, look) @ make_transform(yaw_matrix(roll), np.zeros(3))


def intrinsics(focal: float) -> NDArray[np.float64]:
    """K of a camera whose optical axis meets the middle of the picture."""
    return np.array([[focal, 0, (WIDTH - 1) / 2], [0, focal, (HEIGHT_PX - 1) / 2], [0, 0, 1]])


def shell(room: OpenRoom) -> dict[str, PaintedMesh]:
    """Floor, ceiling and the four walls, with uv in metres."""
    x, y = room.size
    corners = {
        "floor": [(0, 0, 0), (x, 0, 0), (x, y, 0), (0, y, 0)],
        "ceiling": [(0, 0, HEIGHT), (0, y, HEIGHT), (x, y, HEIGHT), (x, 0, HEIGHT)],
        "north": [(0, y, 0), (x, y, 0), (x, y, HEIGHT), (0, y, HEIGHT)],
        "south": [(x, 0, 0), (0, 0, 0), (0, 0, HEIGHT), (x, 0, HEIGHT)],
        "west": [(0, 0, 0), (0, y, 0), (0, y, HEIGHT), (0, 0, HEIGHT)],
        "east": [(x, y, 0), (x, 0, 0), (x, 0, HEIGHT), (x, y, HEIGHT)],
    }
    parts = {}
    for name, four in corners.items():
        points = np.array(four, dtype=float)
        side, up = np.linalg.norm(points[1] - points[0]), np.linalg.norm(points[3] - points[0])
        uv = np.array([(0, 0), (side, 0), (side, up), (0, up)], dtype=float)
        parts[name] = PaintedMesh(points, np.array([(0, 1, 2), (0, 2, 3)]), None, uv, (0.9, 0.9, 0.88), None, 1.0)
    return parts


def in_room(thing: PlacedModel) -> list[PaintedMesh]:
    """The parts of a thing in its place."""
    assert isinstance(thing.model, PackModel)
    turn = yaw_matrix(thing.yaw)
    return [
        replace(
            part,
            vertices=part.vertices @ turn.T + np.array(thing.position),
            normals=None if part.normals is None else part.normals @ turn.T,
        )
        for part in thing.model.parts
    ]


def surfaces(room: OpenRoom) -> list[PlacedMesh]:
    """All that a camera can see; things are numbered from 1 on in their order, walls follow them, then the floor."""
    count = len(room.things)
    owners = {"floor": count + len(WALLS) + 1} | {wall: count + 1 + k for k, wall in enumerate(WALLS)}
    found = [PlacedMesh(part, owners.get(name, 0), MATT) for name, part in shell(room).items()]
    for number, thing in enumerate(room.things, 1):
        parts = in_room(thing)
        whole = thing.model.size[1] * thing.model.size[2] if thing.model.kind == "mirror" else np.inf
        for part in parts:
            dark = thing.model.kind in SCREENS and max(part.color) < 0.25 and part.picture is None
            kind = (
                MIRROR
                if _measure_facing_area(part, thing.yaw) > 0.5 * whole
                else GLASS
                if part.opacity < CLEAR
                else DARK
                if dark
                else MATT
            )
            found.append(PlacedMesh(part, number, kind))
    return found


def _measure_facing_area(part: PaintedMesh, yaw: float) -> float:
    """The area of a part that faces `yaw`: of a mirror its glass, and what it lies on."""
    a, b, c = (part.vertices[part.faces[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a) / 2 @ [np.cos(yaw), np.sin(yaw), 0.0]
    return float(np.abs(areas).sum() / 2 if len(areas) > 2 else np.abs(areas).sum())


@dataclass(frozen=True)
class Caster:
    """Rays against surfaces."""

    surfaces: list[PlacedMesh]

    @cached_property
    def scene(self) -> o3d.t.geometry.RaycastingScene:
        """Open3D's, a geometry per surface."""
        scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        for surface in self.surfaces:
            scene.add_triangles(surface.part.vertices.astype(np.float32), surface.part.faces.astype(np.uint32))
        return scene

    def hits(self, origins: Floats, directions: Floats) -> tuple[Floats, NDArray[np.int64], Floats]:
        """Length to the first opaque pixel of a picture, index of its surface (-1: none), and its normal; for rays
        (N, 3), (N, 3) whose directions may have any length, in these lengths."""
        length, which = np.zeros(len(origins)), np.full(len(origins), -1)
        normal = np.zeros((len(origins), 3))
        going = np.arange(len(origins))
        travelled = np.zeros(len(origins))
        for _ in range(MOST_LAYERS):
            start = origins[going] + directions[going] * travelled[going, None]
            rays = np.concatenate([start, directions[going]], axis=1).astype(np.float32)
            found = self.scene.cast_rays(o3d.core.Tensor(rays))
            distance = found["t_hit"].numpy().astype(float)
            there = np.isfinite(distance)
            going, distance = going[there], distance[there]
            index = found["geometry_ids"].numpy()[there].astype(int)
            face, bary = found["primitive_ids"].numpy()[there], found["primitive_uvs"].numpy()[there]
            clear = self._clear(index, face, bary)
            travelled[going] += distance
            stop = going[~clear]
            length[stop], which[stop] = travelled[stop], index[~clear]
            normal[stop] = found["primitive_normals"].numpy()[there][~clear]
            going = going[clear]
            travelled[going] += OFF
            if not len(going):
                break
        return length, which, normal

    def _clear(self, index: NDArray[np.int64], face: NDArray[np.uint32], bary: Floats) -> NDArray[np.bool_]:
        """Where a picture has a hole: leaves are cut out of rectangles."""
        clear = np.zeros(len(index), dtype=bool)
        for number in np.unique(index):
            part = self.surfaces[number].part
            if part.picture is None or part.uv is None or part.picture.shape[2] < 4:
                continue
            hit = index == number
            corners = part.uv[part.faces[face[hit]]]
            weights = np.column_stack([1 - bary[hit].sum(axis=1), bary[hit]])
            uv = np.einsum("nk,nkd->nd", weights, corners) % 1.0
            rows = ((1 - uv[:, 1]) * part.picture.shape[0]).astype(int).clip(0, part.picture.shape[0] - 1)
            columns = (uv[:, 0] * part.picture.shape[1]).astype(int).clip(0, part.picture.shape[1] - 1)
            clear[hit] = part.picture[rows, columns, 3] < 128
        return clear


def cast_view(caster: Caster, pose: Floats, focal: float) -> tuple[SensorView, NDArray[np.uint16]]:
    """What the camera sees, and the owner of every pixel."""
    rows, columns = np.indices((HEIGHT_PX, WIDTH))
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1).reshape(-1, 3)
    directions = pixels @ np.linalg.inv(intrinsics(focal)).T @ pose[:3, :3].T  # length 1 along the axis
    origins = np.broadcast_to(pose[:3, 3], directions.shape)
    depth, which, normal = caster.hits(origins, directions)
    kinds = np.array([*(surface.kind for surface in caster.surfaces), MATT])
    surface, owner = kinds[which], np.array([*(surface.owner for surface in caster.surfaces), 0])[which]
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    cosine = np.abs((unit * normal).sum(axis=1))
    beyond = depth.copy()
    for kind in (GLASS, MIRROR):
        at = np.flatnonzero(surface == kind)
        if not len(at):
            continue
        onward = directions[at]
        if kind == MIRROR:
            onward = onward - 2 * (onward * normal[at]).sum(axis=1, keepdims=True) * normal[at]
        start = origins[at] + directions[at] * depth[at, None] + OFF * onward
        beyond[at] = depth[at] + caster.hits(start, onward)[0]
    seen = (each.reshape(HEIGHT_PX, WIDTH) for each in (depth, cosine, beyond, surface.astype(np.uint8)))
    return SensorView(*seen), owner.reshape(HEIGHT_PX, WIDTH).astype(np.uint16)


def top_of(thing: PlacedModel, points: Floats) -> Floats:
    """Height of what a thing shows from above at points (N, 2) of the room; NaN beside it."""
    caster = Caster([PlacedMesh(part, 1, MATT) for part in in_room(thing)])
    down = np.tile([0.0, 0.0, -1.0], (len(points), 1))
    above = HEIGHT + 1.0
    length, which, _ = caster.hits(np.column_stack([points, np.full(len(points), above)]), down)
    return np.where(which >= 0, above - length, np.nan)


def share_seen(
    caster: Caster, thing: PlacedModel, number: int, owner: NDArray[np.uint16], pose: Floats, focal: float
) -> float:
    """How much of what would be seen of a thing alone, also beyond the picture's border, is seen."""
    alone = Caster([s for s in caster.surfaces if s.owner == number])
    wide = focal / 2.5
    _, mask = cast_view(alone, pose, wide)
    whole = float((mask > 0).sum()) * 2.5**2
    return float((owner == number).sum()) / max(whole, 1.0)
