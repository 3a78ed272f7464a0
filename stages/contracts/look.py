"""`look.json`: how the room of a picture looks, as `pictures scenes` estimates it and the exports read it."""

from typing import Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.types import Coordinate, Finite, Fraction, Id, UnitVector, check_unique

Color = tuple[Fraction, Fraction, Fraction]
GAMMA = 2.2  # of pictures; base colors are linear
ROOM_LIGHT = (0.55, -0.5, -1.0)  # over the photographer's left shoulder: x of the floor frame is the viewing direction


class Surface(Contract):
    """Floor or wall: its base color (linear RGB), and the part of it that the picture shows."""

    id: Id = Field(description="'floor', or the id of a wall")
    colour: Color
    low: tuple[Coordinate, Coordinate] = Field(description="floor: least x and y; wall: left along its tangent, and 0")
    high: tuple[Coordinate, Coordinate] = Field(description="floor: largest x and y; wall: right, and height")


class Look(Document):
    """Floor, walls and key light of a room, in the floor frame. What the picture does not show is not in it."""

    light: UnitVector = Field(description="direction in which the key light shines")
    light_from: Literal["shadows", "default"] = Field(description="what the direction was taken from")
    shadow_correlation: Finite = Field(description="of predicted shadows with dark places of the picture, -1 to 1")
    surfaces: list[Surface]

    @model_validator(mode="after")
    def _check_ids(self) -> "Look":
        check_unique("surfaces: ids", [surface.id for surface in self.surfaces])
        return self
