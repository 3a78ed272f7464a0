"""Contract of `things.json`, beside a scene's input: what was found in the picture, and how sure it is."""

from pathlib import Path

from pydantic import Field, model_validator

from roomkin.stages.contracts.files import Contract, Document, read_json
from roomkin.stages.contracts.types import Count, Extent, Fraction, MaskValue, Text, check_unique

THINGS = "things.json"


class Name(Contract):
    """A name that a thing may have."""

    name: Text = Field(description="category in words, e.g. 'coffee table'")
    probability: Fraction


class Found(Contract):
    """What a thing may be."""

    names: list[Name] = Field([], max_length=10, description="surest first; empty: nobody asked")
    other: Fraction = Field(0.0, description="probability that it is none of the library's categories")

    @property
    def probability(self) -> float:
        """Of its first name; 0: it has none."""
        return self.names[0].probability if self.names else 0.0

    @property
    def guess(self) -> str:
        """The names that it may have, e.g. `chair, 62 %`."""
        return f"{self.names[0].name}, {100 * self.probability:.0f} %" if self.names else "thing"


class Thing(Found):
    """One thing that was found, placed or not."""

    mask: MaskValue = Field(description="value of its pixels in masks.png; what is left out keeps its own there")
    score: Fraction | None = Field(None, description="of its outline; null: of a drawing")
    source: Text = Field(description="what proposed it: 'ssd', 'mobile_sam', ..., 'drawing'")
    left_out: str = Field("", max_length=1000, description="why it is not placed; empty: it is placed")


class Ground(Contract):
    """The ground plane, by geometry."""

    camera_height: Extent = Field(description="of the camera above the ground, metres")
    taken_from: Text = Field(description="what shows it, for people: 'a level surface below which 0.3 % of points lie'")
    share: Fraction = Field(description="of the picture that shows it")


class Things(Document):
    """`things.json`: what annotations.json does not name of it is left out of the scene."""

    ground: Ground | None = Field(None, description="null: none was found")
    walls: Count
    things: list[Thing]

    @model_validator(mode="after")
    def _masks_once(self) -> "Things":
        check_unique("things: mask values", [item.mask for item in self.things])
        return self

    @property
    def left_out(self) -> list[Thing]:
        """Things that are not placed, the surest first."""
        return sorted((item for item in self.things if item.left_out), key=lambda item: -item.probability)


def read_things(folder: Path) -> Things | None:
    """The things that were found in the picture of an input folder; None: its masks are from elsewhere."""
    path = folder / THINGS
    return read_json(Things, path) if path.is_file() else None
