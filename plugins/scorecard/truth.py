"""The truth of a room: what its things really are, and where. Frame: the world, z up, a corner of the floor at (0, 0).

Metres and radians; x to the right and y away from whoever stands at the wall y = 0.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from roomkin.stages.contracts.errors import InputError, file_missing, suggest_nearest
from roomkin.stages.contracts.files import first_error, read_text
from roomkin.stages.geometry.boxes import UprightBox

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
