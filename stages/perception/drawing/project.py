"""What was drawn: `project.json`, which the page saves as it goes and opens again. Pixels of the upright picture."""

from typing import Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.parts import Panel
from roomkin.stages.contracts.things import Found
from roomkin.stages.contracts.types import Id, Length, Outline, Panels, Pixel, Side, Text, check_unique
from roomkin.stages.perception.camera.perspective import Perspective


class Scale(Contract):
    """One known length."""

    kind: Literal["camera", "object", "floor", "upright", "depth"] = Field(
        "camera", description="height of the camera; a side of an object; a line on the floor or up from it; `--depth`"
    )
    metres: Length | None = Field(None, description="null: unknown; the camera is then assumed to be 1.5 m high")
    points: tuple[Pixel, Pixel] | None = None
    object: Id | None = None
    side: Literal["width", "depth", "height"] = "height"


class DrawnWall(Contract):
    """A line on the floor where a wall stands; `free`: not along an axis of the room."""

    id: Id
    a: Pixel
    b: Pixel
    free: bool = False


class FoundOutline(Found):
    """What networks think that a thing is, and the pixels that show it."""

    id: Id
    articulated: bool = False
    outline: Outline = Field([], description="the pixels that show it; empty: all of its box")
    pieces: list[Outline] = Field([], max_length=50, description="further outlines, where what is before it cuts it")

    @property
    def outlines(self) -> list[list[Pixel]]:
        """Its outline, and those of its further pieces."""
        return [points for points in (self.outline, *self.pieces) if len(points) > 2]


class Guess(FoundOutline):
    """A thing that was found and is not drawn; a click on the page draws it."""

    left_out: Text = Field(description="why it is not drawn")


class DrawnObject(FoundOutline):
    """A box: standing, by its front's lower corners, top, rear corner; on a wall by its front's corners, rear one."""

    label: str = Field("", max_length=1000)
    on: Id = Field("floor", description="floor, the id of a wall or of another object")
    points: list[Pixel] = Field(min_length=2, max_length=4)
    width: Length | None = Field(None, description="metres, if known; null: from the picture")
    depth: Length | None = None
    height: Length | None = None
    free: bool = Field(False, description="not along an axis of the room")
    round: bool = Field(False, description="its points are the ends of its base, and the middle or an end of its top")
    faces: Literal["front", "left", "right", "rear"] = Field(
        "front", description="the drawn side that is its real front, as seen from the side drawn as its front"
    )
    doors: Panels = 0
    drawers: Panels = 0
    panels: list[Panel] = Field([], max_length=1000, description="where they lie on its real front, if that was drawn")
    layer: int = Field(0, ge=-1000, le=1000, description="what has more is seen before what has less, however near")
    unsure: bool = Field(False, description="found by networks, and no person has changed or confirmed it yet")

    @property
    def sizes(self) -> tuple[float | None, float | None, float | None]:
        """Width, depth and height that were typed."""
        return self.width, self.depth, self.height


class Project(Document):
    """Everything that was drawn into one picture."""

    picture: Text = Field(description="file name, for people")
    digest: str = Field("", pattern="^([0-9a-f]{64})?$", description="SHA-256 of that file; empty: not known")
    width: Side
    height: Side
    perspective: Perspective
    scale: Scale = Scale()
    walls: list[DrawnWall] = Field([], max_length=50)
    objects: list[DrawnObject] = Field([], max_length=500)
    left_out: list[Guess] = Field([], max_length=500)
    untouched: bool = Field(False, description="drawn by networks, and no person has saved it on the page since")

    def check_picture(self, digest: str, width: int, height: int, where: object, mend: str) -> "Project":
        """The drawing, if it is of the picture of this digest, as far as it knows that, and size.

        Raises:
            InputError: it is not.
        """
        if self.digest not in ("", digest):
            raise InputError(where, f"is of another picture, '{self.picture}'.", mend, code="E-PROJECT-PICTURE")
        if (self.width, self.height) != (width, height):
            what = f"is of a picture of {self.width}x{self.height} pixels, this one has {width}x{height}."
            raise InputError(where, what, mend, code="E-PROJECT-SIZE")
        return self

    @model_validator(mode="after")
    def _ids_once(self) -> "Project":
        check_unique("ids", ["floor", *(wall.id for wall in self.walls), *(item.id for item in self.objects)])
        return self
