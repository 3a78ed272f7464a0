"""What was drawn: `project.json`, which the page saves as it goes and opens again. Pixels of the upright picture.

Usual values: a size in place of an absurd one, and the camera's height where nobody gave it.
"""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from roomkin.stages.contracts.categories import known_categories, sizes_of
from roomkin.stages.contracts.category import USUAL_SPREAD, describe_unusual, find_category
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, Document
from roomkin.stages.contracts.parts import Panel
from roomkin.stages.contracts.things import Found
from roomkin.stages.contracts.types import Id, Length, Outline, Panels, Pixel, Side, Text, check_unique
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception.camera.metrology import DRAWING_ERROR
from roomkin.stages.perception.camera.perspective import Perspective

CAMERA_HEIGHT = 1.5  # metres: assumed height of a camera whose height is unknown
SURE = np.log(1.1)  # a person who stands holds a camera 1.35 to 1.65 m high: CAMERA_HEIGHT is never better than that
MIN_EXTENT = 0.02  # metres: what hangs is wider and higher, unless one edge of it was marked
Sides = tuple[float | None, float | None, float | None]


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
    def sizes(self) -> Sides:
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


def is_edge_marked(box: UprightBox) -> str:
    """Whether an edge of a hanging object was marked instead of two opposite corners."""
    width, _, height = box.size
    if min(width, height) >= MIN_EXTENT:
        return ""
    side = f"{100 * width:.1f} cm wide" if width < height else f"{100 * height:.1f} cm high"
    return f"would be {side}: of what hangs mark two opposite corners of its front"


def describe_odd(item: DrawnObject, box: UprightBox, factor: float) -> str:
    """What is wrong with the size of a box, by the usual sizes of its label, if it were `factor` times as large."""
    size = box.size[[0, 1, 2] if item.faces in ("left", "right") else [1, 0, 2]]
    if size.min() < DRAWING_ERROR:
        return f"would be {1000 * size.min():.1f} mm thin: draw it anew"
    known = find_category(item.label, known_categories())
    return describe_unusual(known, factor * size) and describe_unusual(known, size)


def find_usual_size(item: DrawnObject, box: UprightBox) -> Sides | None:
    """Width, depth and height that a thing of this label usually has, metres, where the box's is not; None: all are."""
    known = sizes_of(item.label)
    if not len(known):
        return None
    known = known[:, [0, 1, 2] if item.faces in ("left", "right") else [1, 0, 2]]
    excess = np.abs(np.log(box.size) - np.log([known.min(axis=0), known.max(axis=0)]).mean(axis=0))
    odd = excess > USUAL_SPREAD + np.log(known.max(axis=0) / known.min(axis=0)) / 2
    if not odd.any():
        return None
    usual = zip(odd, np.median(known, axis=0), strict=True)
    width, depth, height = (round(float(metres), 2) if is_odd else None for is_odd, metres in usual)
    return width, depth, height


def camera_factor(project: Project, boxes: Mapping[str, UprightBox]) -> float | None:
    """By what the height of a camera that nobody gave should be multiplied; None: nothing speaks against it.

    Each thing whose height is read off the picture allows the factors that make it as high as a model of its category.
    It is doubted where more than half of them are as high as no model, and would be usual with the median of what would
    make each as high as its category is. One thing alone may be drawn a little wrongly: it has to be off by `SURE`.
    What stands on another thing says nothing: it errs with that.
    """
    if project.scale.kind != "camera" or project.scale.metres is not None:
        return None
    ranges = [found for item in project.objects if (found := _bound_factors(item, boxes)) is not None]
    if not ranges:
        return None
    factor, slack = float(np.median([(low + high) / 2 for low, high in ranges])), SURE if len(ranges) == 1 else 0
    unusual = sum(not low - slack <= 0 <= high + slack for low, high in ranges)
    fitting = sum(low - USUAL_SPREAD <= factor <= high + USUAL_SPREAD for low, high in ranges)
    wrong = 2 * min(unusual, fitting) > len(ranges) and abs(factor) > SURE
    return float(np.exp(factor)) if wrong else None


def _bound_factors(item: DrawnObject, boxes: Mapping[str, UprightBox]) -> tuple[float, float] | None:
    """Logarithms of the least and the largest factor that make a thing as high as a model of its category."""
    heights = sizes_of(item.label)[:, 2]
    stands = item.on == "floor"
    marked = item.height is None and item.on not in boxes and len(item.points) >= (3 if stands else 2)
    if item.id not in boxes or not marked or not len(heights):
        return None
    low, high = np.log([heights.min(), heights.max()]) - np.log(boxes[item.id].size[2])
    return float(low), float(high)
