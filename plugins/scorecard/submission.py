"""What a method submits: for every room its things: name, center, size and yaw (docs/results/scorecard.md)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator
from trimesh import Trimesh

from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.parts import HingeSide
from roomkin.stages.contracts.types import Angle, MaskValue, Position, RigidTransform, Size, Text

GIVEN = ("depth", "drawn masks", "exact masks", "names", "panels", "clicks", "camera pose", "length")
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
