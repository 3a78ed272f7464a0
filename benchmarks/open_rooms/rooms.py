"""Furnish the rooms of rooms.yaml: models drawn by chance, each at its place, none in another."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import yaml
from numpy.typing import NDArray
from shapely import Polygon

from roomkin.stages.geometry.boxes import UprightBox, footprint
from roomkin.stages.geometry.frames import wrap_angle

TRIES = 25
CROWD, CROWDS = "crowd", 10  # a kind that is there to learn from alone; times as many of it
LEARNING = 100  # number of the first picture of a kind that is there to learn from
TURNED = {"wall": 0.0, "hang": 0.0, "xy": 12.0, "by": 6.0, "upon": 35.0}  # degrees by which a thing is turned by chance
NUDGED = 0.06  # metres by which free-standing things are moved by chance
CLEAR = 0.01  # metres between things
LEVEL = 0.012  # metres by which the surface under a thing may go up and down
SOFT = {"bed", "sofa", "corner_sofa"}  # ... and under a thing on these, 5 times that
HEIGHT = 2.6
WALLS = ("north", "west", "east")


class ModelSize(Protocol):
    """What a layout knows of a model: size is depth, width, height."""

    @property
    def id(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def size(self) -> tuple[float, float, float]: ...


@dataclass(frozen=True)
class PlacedModel:
    """A model in its place. `support`: floor, wall, or the name of the thing beneath; `wall`: that it touches."""

    name: str
    model: ModelSize
    position: tuple[float, float, float]  # of the middle of its bottom
    yaw: float
    support: str
    wall: str = ""

    @property
    def box(self) -> UprightBox:
        """Its box."""
        x, y, z = self.position
        return UprightBox((x, y, z + self.model.size[2] / 2), self.model.size, self.yaw)


@dataclass(frozen=True)
class OpenRoom:
    """A furnished room: `size` along x and y; camera at `eye`, looking at `look`."""

    kind: str
    size: tuple[float, float]
    eye: tuple[float, float, float]
    look: tuple[float, float, float]
    things: list[PlacedModel] = field(default_factory=list)


# Height of a thing's surface at points; NaN: none.
Top = Callable[[PlacedModel, NDArray[np.float64]], NDArray[np.float64]]


@cache
def plans() -> dict[str, dict[str, Any]]:
    """rooms.yaml."""
    return dict(yaml.safe_load((Path(__file__).parent / "rooms.yaml").read_text()))


def names(half: str, learning: int = 0) -> list[str]:
    """All rooms of a half; or as many of each kind, to learn from."""
    drawn = {kind: plan["draws"][half] for kind, plan in plans().items() if half in plan["draws"]}
    numbers = {kind: range(LEARNING, LEARNING + learning) for kind in drawn}
    numbers[CROWD] = range(LEARNING, LEARNING + CROWDS * learning)
    if not learning:
        numbers = {kind: range(1, draws + 1) for kind, draws in drawn.items()}
    return [f"{half.replace('_', '-')}_{kind}_{number}" for kind, own in numbers.items() for number in own]


def mirror_plan(plan: dict[str, Any]) -> dict[str, Any]:
    """The same room with left and right exchanged; the models stay as they are."""
    across = plan["size"][0]
    other = {"west": "east", "east": "west", "left": "right", "right": "left"}

    def thing(spot: dict[str, Any]) -> dict[str, Any]:
        turned = dict(spot)
        for key in ("wall", "hang", "side"):
            if key in spot:
                turned[key] = other.get(spot[key], spot[key])
        if spot.get("wall", spot.get("hang")) == "north":
            turned["at"] = across - spot["at"]
        if "xy" in spot:
            turned |= {"xy": [across - spot["xy"][0], spot["xy"][1]], "turn": 180 - spot.get("turn", 0)}
        elif "turn" in spot:
            turned["turn"] = -spot["turn"]
        if "shift" in spot:
            turned["shift"] = -spot["shift"]
        return turned

    (x, y), look = plan["camera"]["eye"], plan["camera"]["look"]
    camera = plan["camera"] | {"eye": [across - x, y], "look": [across - look[0], *look[1:]]}
    return plan | {"camera": camera, "things": [thing(spot) for spot in plan["things"]]}


def furnish(
    kind: str, models: Sequence[ModelSize], top: Top, rng: np.random.Generator, plan: Mapping[str, Any] | None = None
) -> OpenRoom:
    """One room of a kind, or by a plan; `rng` decides on models, places and camera."""
    plan = dict(plan or plans()[kind])
    if rng.random() < 0.5:
        plan = mirror_plan(plan)
    camera = plan["camera"]
    eye = np.array([*camera["eye"], rng.uniform(*camera.get("height", (1.15, 1.7)))])
    eye[:2] += rng.uniform(-0.2, 0.2, 2)
    look = np.array(camera["look"]) + rng.uniform(-0.15, 0.15, 3)
    room = OpenRoom(kind, tuple(plan["size"]), tuple(eye.tolist()), tuple(look.tolist()))
    for spot in plan["things"]:
        if rng.random() < spot.get("chance", 1.0):
            room.things.extend(_furnish_spot(spot, room, models, top, rng))
    return room


def _furnish_spot(
    spot: dict[str, Any], room: OpenRoom, models: Sequence[ModelSize], top: Top, rng: np.random.Generator
) -> Iterator[PlacedModel]:
    """The thing of one spot, if it can be put there in a few tries."""
    there = {thing.name: thing for thing in room.things}
    other = there.get(str(spot.get("by", spot.get("upon", ""))))
    if other is None and ("by" in spot or "upon" in spot):
        return
    name = str(spot.get("name", spot["kinds"][0]))
    name = name if name not in there else f"{name}_{len(there)}"
    for _ in range(TRIES):
        model = _draw_model(spot, room, models, rng)
        if model is None:
            return
        thing = _place_model(spot, name, model, room, other, top, rng)
        if thing is not None and _is_free(thing, room, other if spot.get("by") else None):
            yield thing
            return


def _draw_model(
    spot: dict[str, Any], room: OpenRoom, models: Sequence[ModelSize], rng: np.random.Generator
) -> ModelSize | None:
    """A model for the spot: one not used yet if there is any, small enough, wide enough."""
    if "like" in spot:
        return next((thing.model for thing in room.things if thing.name == spot["like"]), None)
    used = {thing.model.id for thing in room.things}
    kinds = sorted({model.kind for model in models} & set(spot["kinds"]))
    if not kinds:
        return None
    kind = str(rng.choice([name for name in spot["kinds"] if name in kinds]))
    fitting = [
        model
        for model in models
        if model.kind == kind and model.size[2] <= spot.get("tall", 9) and model.size[1] >= spot.get("wide", 0)
    ]
    fresh = [model for model in fitting if model.id not in used] or fitting
    return fresh[int(rng.integers(len(fresh)))] if fresh else None


def _place_model(
    spot: dict[str, Any],
    name: str,
    model: ModelSize,
    room: OpenRoom,
    other: PlacedModel | None,
    top: Top,
    rng: np.random.Generator,
) -> PlacedModel | None:
    how = next(key for key in TURNED if key in spot)
    yaw = np.deg2rad(spot.get("turn", 0.0) + rng.uniform(-1, 1) * TURNED[how] * ("spot" not in spot or how != "upon"))
    depth, width, _ = model.size
    if how in ("wall", "hang"):
        wall, across = spot[how], np.array(room.size)
        inward = {"north": (0.0, -1.0), "west": (1.0, 0.0), "east": (-1.0, 0.0)}[wall]
        gap = spot.get("gap", rng.uniform(0.0, 0.03) if how == "wall" else 0.002)
        at = spot["at"] + rng.uniform(-1, 1) * NUDGED
        start = {"north": (at, across[1]), "west": (0.0, at), "east": (across[0], at)}[wall]
        x, y = np.array(start) + np.array(inward) * (gap + depth / 2)
        height = spot["bottom"] if how == "hang" else 0.0
        turned = float(np.arctan2(inward[1], inward[0]))
        support = "wall" if how == "hang" else "floor"
        return PlacedModel(name, model, (float(x), float(y), height), turned, support, wall)
    if how == "xy":
        x, y = np.array(spot["xy"]) + rng.uniform(-1, 1, 2) * NUDGED
        return PlacedModel(name, model, (float(x), float(y), 0.0), wrap_angle(float(yaw)), "floor")
    assert other is not None
    front = np.array([np.cos(other.yaw), np.sin(other.yaw)])
    left = np.array([-front[1], front[0]])
    middle = np.array(other.position[:2])
    if how == "by":
        towards = {"front": front, "back": -front, "left": left, "right": -left}[spot["side"]]
        along = left if spot["side"] in ("front", "back") else front
        yaw = yaw if not spot.get("flush") else np.deg2rad(spot.get("turn", 0.0))
        turned = other.yaw + float(yaw)
        ours = np.array([np.cos(turned), np.sin(turned)])
        reach = abs(towards @ ours) * depth + abs(towards @ [-ours[1], ours[0]]) * width
        reach += abs(towards @ front) * other.model.size[0] + abs(towards @ left) * other.model.size[1]
        shift = spot.get("shift", 0.0) + ((depth - other.model.size[0]) / 2 if spot.get("flush") else 0.0)
        x, y = middle + towards * (reach / 2 + spot.get("gap", 0.1)) + along * shift
        wall = other.wall if spot.get("flush") else ""
        return PlacedModel(name, model, (float(x), float(y), 0.0), wrap_angle(turned), "floor", wall)
    shares = np.array(spot.get("spot", rng.uniform(-0.85, 0.85, 2))) + rng.uniform(-0.08, 0.08, 2)
    half = np.array(other.model.size[:2]) / 2
    x, y = middle + front * shares[0] * half[0] + left * shares[1] * half[1]
    placed = PlacedModel(name, model, (float(x), float(y), 0.0), wrap_angle(other.yaw + float(yaw)), other.name)
    return _let_thing_down(placed, other, top)


def _let_thing_down(thing: PlacedModel, carrier: PlacedModel, top: Top) -> PlacedModel | None:
    """The thing on what is beneath it; None: that is not level, or ends there."""
    under = np.array(footprint(thing.box).exterior.coords)[:4]
    middle = under.mean(axis=0)
    points = np.concatenate([[middle], middle + 0.9 * (under - middle), middle + 0.5 * (under - middle)])
    heights = top(carrier, points)
    if np.isnan(heights).any() or np.ptp(heights) > LEVEL * (5 if carrier.model.kind in SOFT else 1):
        return None
    x, y, _ = thing.position
    return PlacedModel(thing.name, thing.model, (x, y, float(heights.max())), thing.yaw, thing.support)


def _is_free(thing: PlacedModel, room: OpenRoom, tucked: PlacedModel | None) -> bool:
    """Whether it is in the room and in no other thing; a chair may be a little under its table."""
    ours = footprint(thing.box)
    across, deep = room.size
    if not Polygon([(0, 0), (across, 0), (across, deep), (0, deep)]).buffer(1e-3).contains(ours):
        return False
    if thing.box.top > HEIGHT:
        return False
    for other in room.things:
        if other is tucked or other.name == thing.support:
            continue
        apart = other.box.bottom >= thing.box.top or thing.box.bottom >= other.box.top
        row = other.wall and other.wall == thing.wall
        if not apart and ours.buffer(0 if row else CLEAR / 2).intersection(footprint(other.box)).area > 1e-4:
            return False
    return True
