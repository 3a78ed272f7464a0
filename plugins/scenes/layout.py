"""Models for all items of a room, none of them in two rooms, and their poses at the room's scale (paper B.1)."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from shapely import Polygon

from roomkin.plugins.scenes.recipe import Against, Beside, Floor, Hung, Item, RoomPlan, WallName
from roomkin.stages.contracts import Asset, InputError
from roomkin.stages.geometry.boxes import UprightBox, footprint
from roomkin.stages.geometry.frames import yaw_matrix

WALL_YAW: dict[WallName, float] = {"back": 0.0, "left": np.pi / 2, "right": -np.pi / 2}
STRETCH = (0.3, 3.0)
TOUCH = 0.002  # metres that two boxes may share before they overlap
Size = tuple[float, float, float]


@dataclass(frozen=True)
class PlacedItem:
    """One item in its place; `support` is 'floor', 'wall' or the name of the item beneath."""

    item: Item
    box: UprightBox
    support: str


@dataclass(frozen=True)
class FurnishedRoom:
    """A furnished room. `half_width` is the stretched one."""

    standing: dict[str, PlacedItem]
    half_width: float


def scale_of(centers: NDArray[np.float64]) -> float:
    """Largest distance between two of the points (N, 3)."""
    return float(max(np.linalg.norm(a - b) for a, b in combinations(centers, 2)))


def _place_at_wall(wall: WallName, along: float, away: float, z: float, half_width: float) -> NDArray[np.float64]:
    """The point `along` a wall and `away` from it."""
    if wall == "back":
        return np.array([away, along, z])
    return np.array([along, away - half_width if wall == "left" else half_width - away, z])


def _place(item: Item, size: Size, room: RoomPlan, done: Mapping[str, PlacedItem], stretch: float) -> PlacedItem:
    depth, _, height = size
    half_width = room.half_width * stretch
    place, support = item.place, "floor"
    if isinstance(place, Beside):
        place = _place_beside(place, size, room, done, stretch)
    if isinstance(place, Against):
        center = _place_at_wall(place.against, place.along * stretch, place.gap + depth / 2, height / 2, half_width)
        yaw = WALL_YAW[place.against]
    elif isinstance(place, Hung):
        center = _place_at_wall(place.hung, place.along * stretch, depth / 2, place.z, half_width)
        yaw, support = WALL_YAW[place.hung], "wall"
    elif isinstance(place, Floor):
        center = np.array([place.floor[0] * stretch, place.floor[1] * stretch, height / 2])
        yaw = np.deg2rad(place.yaw)
    else:
        below = done[place.on_top].box
        free = (below.size[:2] - _turn_extent(size, np.deg2rad(place.yaw))) / 2
        offset = yaw_matrix(below.yaw) @ [place.forward * free[0], place.right * free[1], 0]
        center = np.array([*(below.center + offset)[:2], below.top + height / 2])
        yaw, support = below.yaw + np.deg2rad(place.yaw), place.on_top
    return PlacedItem(item, UprightBox(center, np.array(size), float(yaw)), support)


def _turn_extent(size: Size, yaw: float) -> NDArray[np.float64]:
    c, s = abs(np.cos(yaw)), abs(np.sin(yaw))
    return np.array([c * size[0] + s * size[1], s * size[0] + c * size[1]])


def _place_beside(place: Beside, size: Size, room: RoomPlan, done: Mapping[str, PlacedItem], stretch: float) -> Against:
    """The same wall, next to the other item. Facing a side wall, `right` runs along -x (left wall) or +x."""
    other = done[place.beside]
    wall = next(name for name, yaw in WALL_YAW.items() if np.isclose(yaw, other.box.yaw))
    step = (other.box.size[1] + size[1]) / 2 + place.gap
    side = 1 if place.side == "right" else -1
    axis, sign = (1, side) if wall == "back" else (0, side * (-1 if wall == "left" else 1))
    along = float(other.box.center[axis] + sign * step) / stretch
    return Against(against=wall, along=along)


def place_all(room: RoomPlan, sizes: Mapping[str, Size], stretch: float) -> FurnishedRoom:
    """Every item at one stretch of the room; items come after those they refer to."""
    done: dict[str, PlacedItem] = {}
    for item in room.items:
        done[item.name] = _place(item, sizes[item.name], room, done, stretch)
    return FurnishedRoom(done, room.half_width * stretch)


def arrange(room: RoomPlan, sizes: Mapping[str, Size]) -> FurnishedRoom | None:
    """The room stretched so that its scale is exact; None if these models do not fit into it."""

    def measure_excess(stretch: float) -> float:
        layout = place_all(room, sizes, stretch)
        return scale_of(np.array([standing.box.center for standing in layout.standing.values()])) - room.scale

    if measure_excess(STRETCH[0]) > 0 or measure_excess(STRETCH[1]) < 0:
        return None
    layout = place_all(room, sizes, float(brentq(measure_excess, *STRETCH, xtol=1e-6)))
    return layout if is_valid_layout(layout, room) else None


def is_valid_layout(layout: FurnishedRoom, room: RoomPlan) -> bool:
    """No two boxes overlap, all are inside the room, and what lies on something lies on it wholly."""
    standing = list(layout.standing.values())
    plans = {one.item.name: footprint(one.box) for one in standing}
    for one in standing:
        x0, y0, _, y1 = plans[one.item.name].bounds
        beyond_left = "left" in room.walls and y0 < -layout.half_width - TOUCH
        beyond_right = "right" in room.walls and y1 > layout.half_width + TOUCH
        if beyond_left or beyond_right or min(x0, one.box.bottom) < -TOUCH:
            return False
        if one.support in plans and not plans[one.support].buffer(TOUCH).covers(plans[one.item.name]):
            return False
    return not any(_overlap(a, b, plans) for a, b in combinations(standing, 2))


def _overlap(a: PlacedItem, b: PlacedItem, plans: Mapping[str, Polygon]) -> bool:
    apart = a.box.top <= b.box.bottom + TOUCH or b.box.top <= a.box.bottom + TOUCH
    return not apart and plans[a.item.name].buffer(-TOUCH).intersects(plans[b.item.name])


ATTEMPTS = 400  # draws of a room before it is refused as one that does not fit; chosen for time
SALT = 0x5CE7E  # keeps this draw apart from others with the same seed


@dataclass(frozen=True)
class CastRoom:
    """A room with its models (by item name) and their places."""

    room: RoomPlan
    layout: FurnishedRoom
    assets: dict[str, Asset]


def templates(models: dict[str, Asset]) -> set[str]:
    """Ids of the models that may furnish rooms; near relatives of another model are left out."""
    return {name for name, asset in models.items() if asset.recipe is None or asset.recipe.variation_of is None}


def choose_models(
    room: RoomPlan, models: dict[str, Asset], free: set[str], rng: np.random.Generator, library: Path
) -> dict[str, Asset]:
    """One model per item, all different, by the item's name.

    Raises:
        InputError: no unused model is left for an item.
    """
    chosen: dict[str, Asset] = {}
    left = {name: asset for name, asset in models.items() if name in free}
    for item in room.items:
        able = [name for name, one in left.items() if one.category == item.category and item.model.accepts(one)]
        if not able:
            fault = f"has no model left for '{item.name}' of {room.name}: category {item.category}, "
            fix = f"raise assets.counts.{item.category} (no model stands in two rooms)"
            raise InputError(library, f"{fault}{item.model.text()}.", fix, code="E-MODELS-SHORT")
        chosen[item.name] = left.pop(able[int(rng.integers(len(able)))])
    return chosen


def cast(rooms: Sequence[RoomPlan], models: dict[str, Asset], seed: int, library: Path) -> dict[str, CastRoom]:
    """Models and layout of every room, by the room's name.

    A room's cast depends on the rooms before it, never on those after it: jobs for single rooms agree. Near relatives
    of other models play no part: a larger library has the same rooms. If no remaining models fit a room (one seed of
    twenty has such a room), it takes some of other rooms, and a line on stderr says so.

    Raises:
        InputError: a category is short, or its models are too large for the room.
    """
    rng = np.random.default_rng(np.random.SeedSequence((seed, SALT)))
    able = templates(models)
    free = set(able)
    result = {}
    for room in rooms:
        found = cast_room(room, models, free, rng, library)
        if found is None:
            found = cast_room(room, models, able, rng, library)
            print(f"{room.name}: no models that are left fit its layout: some are of other rooms", file=sys.stderr)
        if found is None:
            fault = f"{room.name}: no choice of models fits its layout."
            raise InputError(library, fault, "raise assets.counts", code="E-MODELS-SHORT")
        result[room.name] = found
        free -= {asset.id for asset in found.assets.values()}
    return result


def cast_room(
    room: RoomPlan, models: dict[str, Asset], able: set[str], rng: np.random.Generator, library: Path
) -> CastRoom | None:
    """The room with models of those `able` to play, by chance; None if no choice of many fits its layout."""
    for _ in range(ATTEMPTS):
        assets = choose_models(room, models, able, rng, library)
        if layout := arrange(room, {name: asset.size for name, asset in assets.items()}):
            return CastRoom(room, layout, assets)
    return None
