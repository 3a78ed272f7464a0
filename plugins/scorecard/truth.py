"""What a method submits (docs/results/scorecard.md), and what is true: a room's things, boxes and joints."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter, ValidationError, model_validator
from trimesh import Trimesh

from roomkin.stages.contracts.errors import InputError, file_missing, suggest_nearest
from roomkin.stages.contracts.files import Contract, Document, first_error, read_text
from roomkin.stages.contracts.parts import HingeSide
from roomkin.stages.contracts.types import Angle, MaskValue, Position, RigidTransform, Size, Text
from roomkin.stages.geometry.boxes import UprightBox

Given = Literal["depth", "drawn masks", "exact masks", "names", "panels", "clicks", "camera pose", "length"]
Cells = NDArray[np.bool_]


class SubmittedThing(Contract):
    """A thing of a room. Its own x axis is its front, `size` is depth, width, height."""

    name: Text
    center: Position = Field(description="of its box, metres")
    size: Size = Field(description="extents along its own axes x, y, z, metres")
    yaw: Angle = Field(0.0, description="turn about the vertical, radians, counterclockwise from above")
    number: MaskValue | None = Field(None, description="its value in the masks that were given")
    support: Text | None = Field(None, description="'floor', 'wall', or the place of another in this list, as text")
    opens: list[HingeSide] = Field([], description="a word a door: the side it is hinged at; 'slide': a drawer")
    mesh: Text | None = Field(None, description="path of a GLB or OBJ beside the JSON; stretched into the box")
    handles: list[Position] = Field([], max_length=50, description="a point on each handle, in the frame of `center`")


class SubmittedRoom(Contract):
    """A room.

    frame: `camera`: x right, y down, z forward, yaw counted from the camera's x axis laid level; `floor`: z up, by
    `floor_from_camera`, which the method found. scale: `free`: right up to one factor, which is taken from the truth.
    """

    frame: Literal["camera", "floor"]
    floor_from_camera: RigidTransform | None = None
    scale: Literal["metric", "free"] = "metric"
    things: Annotated[list[SubmittedThing], Field(max_length=300)]

    @model_validator(mode="after")
    def _check(self) -> "SubmittedRoom":
        if (self.frame == "floor") != (self.floor_from_camera is not None):
            raise ValueError("floor_from_camera: goes with the frame 'floor', and only with it")
        names = {"floor", "wall", *map(str, range(len(self.things)))}
        for place, thing in enumerate(self.things):
            if thing.support is not None and thing.support not in names - {str(place)}:
                raise ValueError(f"things.{place}.support: '{thing.support}' is no other thing's place in the list")
        numbers = [thing.number for thing in self.things if thing.number is not None]
        if len(numbers) != len(set(numbers)):
            raise ValueError("things: two have the same number")
        return self


class About(Document):
    """What must be said of a method: `method.json` of a folder, and the head of a single file."""

    method: Text
    given: list[Given] = Field([], description="beside the picture")
    code: Text = Field(description="address and version of the code, or 'closed'")
    by: Text
    seen: Text = Field(description="what was looked at or trained on of these rooms; 'nothing'")
    note: str = ""


class SubmissionFile(About):
    """A submission in one file. Each room is checked by itself: one that cannot be read is told, and is missed."""

    rooms: dict[str, Any] = Field(max_length=10_000)


@dataclass(frozen=True)
class RoomScene:
    """A room as it was read, and what its format alone can tell.

    Attributes:
        room: its things.
        solids: by place in the list, a thing's surface around the middle of its box, which it fills in any unit.
    """

    room: SubmittedRoom
    solids: Mapping[int, Trimesh] = field(default_factory=dict)


@dataclass(frozen=True)
class Submission:
    """What was read. `unread`: by room, why it could not be."""

    about: About
    rooms: Mapping[str, RoomScene]
    unread: Mapping[str, str]


HANDLES = "handles.json"


@dataclass(frozen=True)
class TrueHandle:
    """The box of a handle, in the frame of its thing's box: its center and its extents. `panel`: a number for each door
    or drawer of the thing, in no order; one may have two handles."""

    panel: int
    position: tuple[float, float, float]
    size: tuple[float, float, float]


@dataclass(frozen=True)
class TrueThing:
    """A thing of a picture as it really is. `number` is its value in masks; `support`: floor, wall, or a number.

    `named`: a person would outline and name it, so that it is asked for. `opens` has a word per door (the side it is
    hinged at, sideways, unknown) and drawer (slide); `handle` is bar, knob, edge or empty. `handles`: where they are,
    if the model's source names one for each door and drawer.
    """

    number: int
    name: str
    model: str
    pack: str
    kind: str
    label: str
    doors: int
    drawers: int
    symmetry: str
    position: tuple[float, float, float]  # of the box's center
    size: tuple[float, float, float]
    yaw: float
    support: str
    wall: str
    pixels: int
    seen: float
    cut: bool
    named: bool
    opens: tuple[str, ...] = ()
    handle: str = ""
    handles: tuple[TrueHandle, ...] = ()

    @property
    def box(self) -> UprightBox:
        """Its box in the world."""
        return UprightBox(self.position, self.size, self.yaw)


@dataclass(frozen=True)
class PictureTruth:
    """The truth of a picture. `joined`: in drawn masks, the value that holds another's pixels, too."""

    name: str
    half: str
    kind: str
    device: str
    focal: float
    size: tuple[float, float]
    world_from_camera: list[list[float]]
    things: list[TrueThing]
    joined: dict[str, int]

    @property
    def pose(self) -> NDArray[np.float64]:
        """world_from_camera (4, 4); the camera has x right, y down, z forward."""
        return np.array(self.world_from_camera)

    def list_asked(self, drawn: bool) -> list[TrueThing]:
        """The things that a submission must have; `drawn`: it was told drawn masks, in which some have no pixels."""
        joined = {int(inner) for inner in self.joined} if drawn else set()
        return [thing for thing in self.things if thing.named and thing.number not in joined]


def read_truth(path: Path) -> PictureTruth:
    """A truth.json, and what handles.json of its set says of the same models.

    Raises:
        InputError: it is missing, or is none.
    """
    try:
        picture = TypeAdapter(PictureTruth).validate_json(read_text(path))
        beside = path.parents[1] / HANDLES
        text = read_text(beside) if beside.is_file() else "{}"
        handles = TypeAdapter(dict[str, tuple[TrueHandle, ...]]).validate_json(text)
    except ValidationError as error:
        mend = "make the rooms again: python -m benchmarks.open_rooms make DIR"
        what = f"is no truth of a room: {first_error(error)}."
        raise InputError(path, what, mend, code="E-CONTRACT-BROKEN") from None
    things = [replace(thing, handles=handles.get(thing.model, ())) for thing in picture.things]
    return replace(picture, things=things)


def list_rooms(data: Path, rooms: str) -> list[Path]:
    """The folders of a set of rooms in the data set, by name.

    Args:
        data: folder that `python -m benchmarks.open_rooms make` wrote.
        rooms: name of the set; `-` and `_` are one.

    Raises:
        InputError: there is no such folder, or no such set.
    """
    if not data.is_dir():
        raise file_missing(data, "python -m benchmarks.open_rooms make DIR, and --data DIR")
    sets = sorted({path.parents[1].name for path in data.glob("*/*/truth.json")})
    name = rooms.replace("-", "_")
    if name not in sets:
        raise InputError(data, f"has no set '{rooms}'.", suggest_nearest(name, sets), code="E-WORDS")
    return sorted(path.parent for path in (data / name).glob("*/truth.json"))


def with_opening(picture: PictureTruth, opens: dict[str, tuple[tuple[str, ...], str]]) -> PictureTruth:
    """The truth with what is known by model of how it opens, and of its handle."""
    none: tuple[tuple[str, ...], str] = ((), "")

    def tell(thing: TrueThing) -> TrueThing:
        words, handle = opens.get(thing.model, none)
        return replace(thing, opens=words, handle=handle)

    return replace(picture, things=[tell(thing) for thing in picture.things])


def as_plain(picture: PictureTruth) -> Any:
    """The truth as plain data; handles are told by model, beside it."""
    return TypeAdapter(PictureTruth).dump_python(picture, mode="json", exclude={"things": {"__all__": {"handles"}}})
