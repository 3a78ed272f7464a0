"""A random room: things of every kind alike, where such things are: at walls, on them, on the floor, on others."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from benchmarks.name_training.solids import JUNK, Array, Rng, Solid, make_junk, make_solid
from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.plugins.furniture.shapes import CUBE
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.library import Placement
from roomkin.stages.geometry.boxes import UprightBox, footprint
from roomkin.stages.geometry.frames import yaw_matrix

FLOOR, WALL = 0, 1  # owners; things are numbered from 2 on
THINGS, TRIES = 45, 8  # in a room at most, and places that are tried for one; chosen
SPREAD = 0.1  # of the logarithm of a thing's size, as a whole and of each side; chosen
AGAINST_WALL = 0.6  # share of large things on the floor that stand with their back to a wall; chosen
LITTLE, ON_FLOOR = 0.5, 0.2  # metres: smaller junk stands on others, but for a share of little things; chosen
UNEVEN = 0.025  # metres by which what a thing stands on may be uneven
# Metres between which the foot of what hangs is, by kind; and at which the top of what hangs low ends; chosen.
FOOT = {"a_door": (0.0, 0.01), "mirror": (0.1, 1.6)}
HANGS = (0.6, 1.9)  # others
TOP = {"curtain": 2.3, "radiator": 0.75, "sink": 0.95, "toilet": 0.45}
MODELS = 2_000_003  # added to the seed: no library has the models of this one
Pool = dict[str, list[Solid]]


@dataclass(frozen=True)
class PlacedThing:
    """A solid stretched by `scale` (3,), turned by `yaw`, its base at `position`; on the floor, a wall or a thing."""

    solid: Solid
    scale: Array
    yaw: float
    position: Array
    support: int  # FLOOR, WALL, or an owner

    @cached_property
    def box(self) -> UprightBox:
        """Its box in the room."""
        size = self.solid.size * self.scale
        return UprightBox(np.add(self.position, [0, 0, size[2] / 2]), size, self.yaw)

    @cached_property
    def plan(self) -> Polygon:
        """Its box from above."""
        return footprint(self.box)

    @property
    def vertices(self) -> Array:
        """(V, 3) in the room."""
        return self.solid.vertices * self.scale @ yaw_matrix(self.yaw).T + self.position


@dataclass(frozen=True)
class MadeRoom:
    """`size` (3,) metres, corner at the origin; the things, each after what carries it."""

    size: Array
    things: list[PlacedThing]

    def is_free(self, new: PlacedThing) -> bool:
        """Whether a thing is in the room and overlaps no other but what carries it, by their boxes."""
        if not shapely.box(-1e-6, -1e-6, *(self.size[:2] + 1e-6)).contains(new.plan) or new.box.top > self.size[2]:
            return False
        return not any(
            other.box.bottom < new.box.top - 0.01
            and other.box.top > new.box.bottom + 0.01
            and number != new.support
            and other.plan.intersection(new.plan).area > 1e-6
            for number, other in enumerate(self.things, 2)
        )


@cache
def make_pool(models: int, seed: int, packs: Path | None = None) -> Pool:
    """So many solids of every category, and of junk; with those of other people's models.

    packs: folder of `benchmarks.open_rooms fetch`; of the half `work` alone.
    """

    def make(kind: str, index: int) -> Solid:
        rng = np.random.default_rng(np.random.SeedSequence((seed + MODELS, *kind.encode(), index)))
        return make_junk(kind, rng) if kind in JUNK else make_solid(kind, rng, index)

    pool = {kind: [make(kind, index) for index in range(models)] for kind in (*CATEGORIES, *JUNK)}
    for kind, solid in read_solids(packs) if packs else ():
        pool[kind].append(solid)
    return pool


def read_solids(packs: Path) -> Iterator[tuple[str, Solid]]:
    """Other people's models that any category of ours is a cousin of, the first of these, and what is none."""
    from benchmarks.open_rooms import packs as others

    for model in others.models(packs, "work"):
        sensible = others.kinds()[model.kind].sensible
        kind = sensible[0] if sensible else "a_body"
        places = known_categories()[kind].places if sensible else ("top",)
        placement: Placement = "floor" if places[0] == "floor" else "wall" if places[0] == "wall" else "object"
        starts = np.cumsum([0, *(len(part.vertices) for part in model.parts[:-1])])
        faces = np.concatenate([part.faces + start for part, start in zip(model.parts, starts, strict=True)])
        yield kind, Solid(kind, np.concatenate([part.vertices for part in model.parts]), faces, placement)


def furnish(pool: Pool, rng: Rng) -> MadeRoom:
    """A room with solids out of the pool, every kind as likely, the largest first."""
    room = MadeRoom(np.array([*rng.uniform(2.4, 7.0, 2), rng.uniform(2.3, 3.2)]), [])
    drawn = []
    for kind in rng.choice(sorted(pool), THINGS):
        solid = pool[str(kind)][int(rng.integers(len(pool[str(kind)])))]
        drawn.append((solid, np.exp(rng.normal(0, SPREAD) + rng.normal(0, SPREAD, 3))))
    for solid, scale in sorted(drawn, key=lambda one: -float(np.prod(one[0].size[:2] * one[1][:2]))):
        tried = (_place(room, solid, scale, rng) for _ in range(TRIES))
        new = next((one for one in tried if one is not None and room.is_free(one)), None)
        if new is not None:
            room.things.append(new)
    return room


def _place(room: MadeRoom, solid: Solid, scale: Array, rng: Rng) -> PlacedThing | None:
    """A place for a thing, where such things are; None: there is none."""
    size, side = solid.size * scale, int(rng.integers(4))
    along = rng.uniform(size[1] / 2, max(size[1] / 2, room.size[side % 2] - size[1] / 2))
    if solid.placement == "wall" or solid.kind in TOP:
        low, high = FOOT.get(solid.kind, HANGS)
        foot = (
            max(0.0, TOP[solid.kind] * rng.uniform(0.9, 1.15) - size[2])
            if solid.kind in TOP
            else rng.uniform(low, high)
        )
        point, yaw = wall_point(room.size, side, along, size[0] / 2)
        return PlacedThing(solid, scale, yaw, np.array([*point, foot]), WALL)
    little = solid.placement == "object" or (solid.kind in JUNK and size.max() < LITTLE)
    if little and rng.random() > ON_FLOOR:
        return _place_upon(room, solid, scale, rng)
    if rng.random() < AGAINST_WALL:
        point, yaw = wall_point(room.size, side, along, size[0] / 2 + rng.choice([0.0, rng.uniform(0, 0.15)]))
    else:
        point, yaw = rng.uniform(0.1, 0.9, 2) * room.size[:2], rng.uniform(0, 2 * np.pi)
    return PlacedThing(solid, scale, yaw, np.array([*point, 0.0]), FLOOR)


def _place_upon(room: MadeRoom, solid: Solid, scale: Array, rng: Rng) -> PlacedThing | None:
    """A place on one of the things that may carry others; None: there it does not lie flat."""
    carriers = [n for n, one in enumerate(room.things, 2) if one.box.size[:2].min() > 0.3 and one.box.size[2] < 1.5]
    if not carriers:
        return None
    owner = int(rng.choice(carriers))
    base = room.things[owner - 2]
    spot = base.position + yaw_matrix(base.yaw)[:, :2] @ (rng.uniform(-0.45, 0.45, 2) * base.box.size[:2])
    new = PlacedThing(solid, scale, base.yaw + rng.normal(0, 0.4), spot, owner)
    corners = np.array(new.plan.exterior.coords)[:4]
    middle = corners.mean(axis=0)
    under = np.array([middle, *(middle + 0.5 * (corners - middle))]) - base.position[:2]
    heights = base.solid.heights(under @ yaw_matrix(base.yaw)[:2, :2] / base.scale[:2]) * base.scale[2]
    if not np.isfinite(heights).all() or np.ptp(heights) > UNEVEN:
        return None
    return PlacedThing(solid, scale, new.yaw, np.add(spot, [0, 0, heights.max()]), owner)


def wall_point(size: Array, side: int, along: float, off: float) -> tuple[Array, float]:
    """A point (2,) `off` a wall into the room, and the yaw that looks away from the wall."""
    into = off if side < 2 else size[1 - side % 2] - off
    point = np.array([along, into] if side % 2 == 0 else [into, along])
    return point, [np.pi / 2, 0.0, -np.pi / 2, np.pi][side]


def triangles(room: MadeRoom) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.int64]]:
    """Vertices (V, 3), faces (F, 3) and owner (F,) of the room, a box from inside, and all that is in it."""
    shell = (CUBE.vertices + 0.5) * room.size
    vertices, faces = [shell], [np.asarray(CUBE.faces)]
    owners = [np.where((shell[CUBE.faces, 2] == 0).all(axis=1), FLOOR, WALL)]
    for owner, thing in enumerate(room.things, 2):
        faces.append(thing.solid.faces + sum(map(len, vertices)))
        vertices.append(thing.vertices)
        owners.append(np.full(len(thing.solid.faces), owner))
    return np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.uint32), np.concatenate(owners)
