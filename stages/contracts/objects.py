"""Contract of the `extraction` stage: `objects.json` and the arrays beside it."""

import math
import re
from collections import Counter
from collections.abc import Iterable
from operator import not_
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeVar

from pydantic import Field, model_validator

from roomkin.stages.contracts import types
from roomkin.stages.contracts.doubt import Doubt, Provenance
from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.parts import Panel, check_counts
from roomkin.stages.contracts.things import Name

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Metres = TypeVar("Metres", float, "NDArray[np.floating]")
FAR_FROM_WALL = 2.0  # metres: what touches a wall is never so far away from it, however wrong its depth


class DepthError(NamedTuple):
    """The error of a depth map: the standard deviation, metres, with which it lies about what it shows, a + b z^2."""

    a: types.NonNegative
    b: types.NonNegative

    def predict(self, distance: Metres) -> Metres:
        """Metres at a distance (or distances) from the camera."""
        return self.a + self.b * distance**2


USUAL_ERROR = DepthError(0.003, 0.0015)  # of depth cameras and networks: 1.7 cm at 3 m


class Wall(Contract):
    """A wall plane in the floor frame: points p with normal . p = offset; the normal is horizontal and faces us."""

    id: types.Id
    normal: types.HorizontalUnitVector
    offset: types.Coordinate
    points: types.Count


class Box(Contract):
    """A z-aligned box in the floor frame; `size` is (x, y, z) along the box's own axes, `yaw` in (-pi/4, pi/4]."""

    center: types.Position
    size: types.Size
    yaw: types.Angle

    @model_validator(mode="after")
    def _check_yaw(self) -> "Box":
        if abs(self.yaw) > math.pi / 4 + types.RIGID_TOLERANCE:
            raise ValueError(f"yaw: {self.yaw:g} is not within pi/4: turn the box by quarters, and swap its x and y")
        return self


HOLDS = {1: "hangs on a wall", 2: "stands free", 3: "stands and touches a wall"}


class Mounting(Contract):
    """Paper A.2: 1 wall mounted, 2 on the floor or on another object, 3 mixture (stands, and touches a wall)."""

    type: Literal[1, 2, 3]
    walls: list[types.Id] = Field([], description="ids of the walls touched, the dominant one first")

    @property
    def words(self) -> str:
        """In words, e.g. `hangs on a wall (wall_1)`."""
        return HOLDS[self.type] + (f" ({', '.join(self.walls)})" if self.walls else "")

    @property
    def hangs(self) -> bool:
        """Whether it is held by a wall alone."""
        return self.type == 1


class SceneObject(Contract):
    """One object of the image."""

    id: types.Id = Field(description="label and running number, e.g. cabinet_1; unique within the scene")
    label: types.Text
    mask: types.MaskValue = Field(description="value of its pixels in masks.png")
    status: Literal["ok", "failed"] = "ok"
    reason: str = Field("", description="why it failed")
    pixels: tuple[types.Count, types.Count, types.Count, types.Count] | None = None  # of its mask: x0, y0, x1, y1
    names: list[Name] = Field([], exclude_if=not_, description="it may have, surest first; empty: label is certain")
    articulated: bool = False
    doors: types.Panels = 0
    drawers: types.Panels = 0
    panels: list[Panel] = Field([], description="where they lie on its front; empty: not known")
    points: types.Count = 0
    depth_known: types.Fraction | None = Field(
        None, description="share of its pixels with known depth; null if not used"
    )
    box: Box | None = Field(None, description="z-aligned minimum box of the cleaned cloud (null if failed)")
    mounting: Mounting | None = None
    measured_support: str = Field(
        "", description="'floor', 'wall', the id of the object beneath, 'unnamed': what nobody named; empty: not said"
    )
    measured_mounting: Mounting | None = Field(None, description="by geometry, where the input tells the mounting")
    note: str = Field("", description="what the input says of it that cannot be")
    front: types.Angle | None = Field(None, description="direction that it faces about z, if the input tells")
    whole: bool = Field(False, description="the input tells its box, hidden sides too, and cousins get that size")
    support: str | None = Field(None, description="'floor' or the id of what carries it, where a person says so")
    told: list[Literal["mounting", "size"]] = Field([], description="what else a person says of it: nobody doubts that")
    doubts: list[Doubt] = Field([], exclude_if=not_, description="what of its name or box the input doubts itself")


class Objects(Document):
    """`objects.json`. Beside it: `masks.png` (uint16, cleaned masks in full-image pixels), `depth.npz`
    (`depth` float32 metres, 0: unknown), `clouds.npz` (one (N, 3) float32 array per object id, floor frame).

    The floor frame: z = 0 on the floor and up along its normal, origin below the camera,
    x along the horizontal part of the viewing direction.
    """

    scene: types.SceneName
    width: types.Side
    height: types.Side
    intrinsics: types.CameraMatrix
    floor_from_camera: types.RigidTransform
    crop: types.Fraction = Field(
        1.0, gt=0, description="central share of the picture that was used, in either direction"
    )
    depth_error: DepthError = Field(
        USUAL_ERROR, description="a (metres) and b (1/metres) of depth's standard deviation a + b z^2"
    )
    walls: list[Wall]
    objects: list[SceneObject]
    lost: list[types.Text] = Field([], exclude_if=not_, description="what could not be kept of a person's corrections")
    digest: str = Field(
        "", pattern="^([0-9a-f]{64})?$", exclude_if=not_, description="SHA-256 of the picture's file; empty: not known"
    )
    made: Provenance | None = None

    @model_validator(mode="after")
    def _check_references(self) -> "Objects":
        types.check_view(self.width, self.height, self.intrinsics)
        check_room(self.floor_from_camera, self.walls)
        types.check_unique("objects: ids", [item.id for item in self.objects])
        types.check_unique("objects: mask values", [item.mask for item in self.objects])
        fixed = ("floor", "wall", "unnamed", "")
        types.check_supports({item.id: item.measured_support for item in self.objects}, fixed)
        walls = {wall.id: wall for wall in self.walls}
        for item in self.objects:
            check_status(item.id, item.status, item.reason)
            if item.status == "ok" and (item.box is None or item.mounting is None):
                raise ValueError(f"objects: '{item.id}' is ok, but has no box or no mounting")
            check_counts(item.id, item.panels, item.doors, item.drawers)
            check_mounting(item.id, item.mounting, set(walls))
            check_mounting(item.id, item.measured_mounting, set(walls))
            if item.support not in {None, "floor", *(other.id for other in self.objects)} - {item.id}:
                raise ValueError(f"objects: the support of '{item.id}' is '{item.support}', which is not there")
            if item.box is not None and item.mounting is not None:
                for name in item.mounting.walls:
                    if (gap := distance_between(item.box, walls[name])) > FAR_FROM_WALL:
                        raise ValueError(f"objects: '{item.id}' touches '{name}', but is {gap:.1f} m away from it")
            if item.pixels is not None:
                x0, y0, x1, y1 = item.pixels
                if not (x0 < x1 <= self.width and y0 < y1 <= self.height):
                    raise ValueError(f"objects: pixels of '{item.id}' are no box inside the picture")
        return self


def check_room(floor_from_camera: types.RigidTransform, walls: list[Wall]) -> None:
    """The camera is in the room: above the floor, before every wall."""
    camera = [row[3] for row in floor_from_camera[:3]]
    if camera[2] <= 0:
        raise ValueError("floor_from_camera: the camera is not above the floor: z is up")
    types.check_unique("walls: ids", [wall.id for wall in walls])
    for wall in walls:
        if sum(n * c for n, c in zip(wall.normal, camera, strict=True)) < wall.offset:
            raise ValueError(f"walls: the camera is behind '{wall.id}': normal and offset of a wall face it")


def distance_between(box: Box, wall: Wall) -> float:
    """Metres between a box and the plane of a wall; 0 if they meet."""
    c, s = math.cos(box.yaw), math.sin(box.yaw)
    x, y, _ = wall.normal
    reach = (abs(x * c + y * s) * box.size[0] + abs(y * c - x * s) * box.size[1]) / 2
    return max(0.0, abs(x * box.center[0] + y * box.center[1] - wall.offset) - reach)


def check_status(name: str, status: str, reason: str) -> None:
    """Refuse an object that failed and does not say why."""
    if status == "failed" and not reason:
        raise ValueError(f"objects: '{name}' failed, but reason is empty")


def check_mounting(name: str, mounting: Mounting | None, walls: set[str]) -> None:
    """The walls that an object touches exist, each once."""
    if mounting is None:
        return
    types.check_unique(f"objects: mounting.walls of '{name}'", mounting.walls)
    for wall in mounting.walls:
        if wall not in walls:
            raise ValueError(f"objects: mounting.walls of '{name}' names '{wall}', which is not in walls")


def object_ids(labels: Iterable[str]) -> list[str]:
    """Ids of objects with these labels: `label_1`, `label_2`, ... in the order given."""
    counts: Counter[str] = Counter()
    ids = []
    for label in labels:
        name = re.sub(r"[^a-z0-9]+", "_", label.lower()).strip("_") or "object"
        counts[name] += 1
        ids.append(f"{name}_{counts[name]}")
    return ids
