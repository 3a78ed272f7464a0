"""A generated scene: `scene.json`, one per cousin rank; `look.json`, its light, floor and walls."""

import math
from collections.abc import Iterable
from operator import not_
from typing import Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts import types
from roomkin.stages.contracts.doubt import Doubt, Provenance
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.library import Finish
from roomkin.stages.contracts.objects import Mounting, Wall, check_mounting, check_room, check_status

Color = tuple[types.Fraction, types.Fraction, types.Fraction]
GAMMA = 2.2  # of pictures; base colors are linear
ROOM_LIGHT = (0.55, -0.5, -1.0)  # over the photographer's left shoulder: x of the floor frame is the viewing direction


class Surface(Contract):
    """Floor or wall: its base color (linear RGB), and the part of it that the picture shows."""

    id: types.Id = Field(description="'floor', or the id of a wall")
    colour: Color
    low: tuple[types.Coordinate, types.Coordinate] = Field(
        description="floor: least x and y; wall: left along its tangent, and 0"
    )
    high: tuple[types.Coordinate, types.Coordinate] = Field(
        description="floor: largest x and y; wall: right, and height"
    )


class Look(Document):
    """Floor, walls and key light of a room, in the floor frame. What the picture does not show is not in it."""

    light: types.UnitVector = Field(description="direction in which the key light shines")
    light_from: Literal["shadows", "default"] = Field(description="what the direction was taken from")
    shadow_correlation: types.Finite = Field(
        description="of predicted shadows with dark places of the picture, -1 to 1"
    )
    surfaces: list[Surface]

    @model_validator(mode="after")
    def _check_ids(self) -> "Look":
        types.check_unique("surfaces: ids", [surface.id for surface in self.surfaces])
        return self


RIGHT_SHARE, RIGHT_MIN = 0.10, 0.03  # a size is right if every extent is: within a share of it, or metres
# A place is right within 5 cm: metres of its spread at which that is as likely as not, and how steep the chance falls;
# calibrated on `work` (docs/results/open.md).
EVEN, STEEP = 0.042, 2.4


class PlacedObject(Contract):
    """A cousin in its place, in the floor frame."""

    id: types.Id
    label: types.Text
    status: Literal["ok", "failed"] = "ok"
    reason: str = ""
    asset: str = ""
    category: str = ""
    position: types.Position = Field((0.0, 0.0, 0.0), description="center of the asset's box, metres")
    yaw: types.Angle = Field(0.0, description="turn of the asset about z, radians")
    size: types.Vector = Field((0.0, 0.0, 0.0), description="box extents along the asset's own axes, metres")
    # Standard deviations of the logarithms of `size`, and of `position`, metres; null: it was not fitted.
    size_spread: types.Vector | None = None
    place_spread: types.NonNegative | None = None
    finish: Finish = Field({}, exclude_if=not_, description="parameters of its recipe that are as the picture shows")
    support: str = Field(
        "floor", description="'floor', 'wall', the id of the object beneath, or 'unnamed': on what is no object here"
    )
    mounting: Mounting | None = None
    cousin: types.Rank | None = Field(None, description="rank in cousins.json of the model that stands here")
    chosen: bool = Field(False, description="a person says which model stands here")
    steps: list[str] = Field([], description="what each step of placing changed, in order, and by how much")
    doubts: list[Doubt] = Field([], description="what may be wrong and a person can mend")
    moved: types.NonNegative = Field(0.0, description="xy distance it was pushed to resolve collisions, metres")
    settled_shift: types.NonNegative | None = Field(None, description="how far it moved in the settling test, metres")


class Plausibility(Contract):
    """Physics check of the scene: load it, let it settle for `seconds`."""

    seconds: types.NonNegative
    stable: bool = Field(description="nothing has fallen or overlaps, is held without a wall, or reaches behind one")
    fallen: list[str] = Field(description="objects that did not stay: they dropped, tipped or were pushed aside")
    how: dict[str, types.Text] = Field({}, exclude_if=not_, description="what each of them did, in words")
    held: list[str] = Field([], description="objects kept where they were seen, since what carries them is not named")
    behind: list[str] = Field([], description="objects that reach behind a wall")
    mean_displacement: types.NonNegative
    max_penetration: types.NonNegative
    collisions: types.Count

    @property
    def wrong(self) -> str:
        """Why the scene does not stand, in words; empty: it stands as it was put."""
        moved = [f"{name} {self.how.get(name, 'has fallen')}" for name in self.fallen]
        return ", ".join(moved + ([f"left with {count(self.collisions, 'collision')}"] if self.collisions else []))

    @property
    def kept(self) -> str:
        """Items that stand only as they are helped, in words; empty: none does."""
        named = {"held, for nothing that was named carries it": self.held, "reaches behind a wall": self.behind}
        return "; ".join(f"{what}: {', '.join(names)}" for what, names in named.items() if names)

    @property
    def verdict(self) -> str:
        """A line: whether the scene stands, and what of it does not or is helped."""
        first = f"does not stand: {self.wrong}" if self.wrong else "stands"
        return f"{first}; {self.kept}" if self.kept else first


class GeneratedScene(Document):
    """`scene.json`: the scene of cousins of one rank, loadable in SAPIEN."""

    scene: types.SceneName
    variant: types.Id
    rank: types.Rank
    width: types.Side
    height: types.Side
    intrinsics: types.CameraMatrix
    floor_from_camera: types.RigidTransform
    walls: list[Wall]
    objects: list[PlacedObject]
    plausibility: Plausibility | None = None
    made: Provenance | None = None

    @model_validator(mode="after")
    def _check_references(self) -> "GeneratedScene":
        types.check_view(self.width, self.height, self.intrinsics)
        check_room(self.floor_from_camera, self.walls)
        types.check_unique("objects: ids", [item.id for item in self.objects])
        walls = {wall.id for wall in self.walls}
        for item in self.objects:
            check_status(item.id, item.status, item.reason)
            if item.status == "failed":
                continue
            if not item.asset or not item.category:
                raise ValueError(f"objects: '{item.id}' is ok, but has no asset or no category")
            if not all(0 < extent <= types.LARGEST for extent in item.size):
                raise ValueError(f"objects: size of '{item.id}' is {item.size} (positive, {types.LARGEST:g} m at most)")
            check_mounting(item.id, item.mounting, walls)
        placed = {item.id: item.support for item in self.objects if item.status == "ok"}
        types.check_supports(placed, ("floor", "wall", "unnamed"))
        for kind in ("fallen", "held", "behind") if self.plausibility else ():
            if strangers := set(getattr(self.plausibility, kind)) - set(placed):
                raise ValueError(f"plausibility.{kind}: names '{min(strangers)}', which is not placed")
        return self


def measure_sureness(size: Iterable[float], spread: Iterable[float]) -> float:
    """The chance that extents (3,), metres, are all right, given the standard deviations (3,) of their logarithms."""
    within = (math.log1p(max(RIGHT_SHARE, RIGHT_MIN / extent)) for extent in size)
    return math.prod(math.erf(far / (each * math.sqrt(2))) for far, each in zip(within, spread, strict=True))


def measure_place_sureness(spread: float) -> float:
    """The chance that a place is right to 5 cm, given the standard deviation of its center, metres."""
    return 1 / (1 + (spread / EVEN) ** STEEP)
