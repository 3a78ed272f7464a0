"""Contract of `corrections.json`, beside a scene's input: what a person says otherwise than the stages found."""

from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from stages.contracts.files import Contract, Document, read_json
from stages.contracts.fronts import Panel, check_counts
from stages.contracts.scenes import Held
from stages.contracts.types import (
    Angle,
    Coordinate,
    Id,
    MaskValue,
    Outline,
    Panels,
    Pixel,
    Size,
    Text,
    check_supports,
    check_unique,
)

CORRECTIONS = "corrections.json"
MEASURED = "measured"
FLOOR = "floor"
Reader = Literal["extraction", "generation"]


class Correction(Contract):
    """One thing, the floor or a wall. What is left out, or null, stays as it was found."""

    mask: MaskValue = Field(description="its value in masks.png; one that is not in there: a thing that was not found")
    gone: bool = Field(False, description="it is no thing of its own")
    label: Text | None = Field(None, description="floor and wall mean what they say")
    named: bool = Field(False, description="a person says its name, be it the one that was proposed: it is not doubted")
    around: tuple[Pixel, Pixel] | None = Field(
        None, description="opposite corners of what shows it; cut out of the picture"
    )
    outline: Outline = Field([], description="the pixels that show it")
    pieces: list[Outline] = Field([], max_length=50, description="further outlines, where what is before it cuts it")
    layer: int = Field(0, ge=-1000, le=1000, description="what has more covers what has less")
    joins: list[MaskValue] = Field([], max_length=1000, description="masks that show further parts of it")
    articulated: bool | None = None
    doors: Panels | None = None
    drawers: Panels | None = None
    panels: list[Panel] | None = Field(
        None, max_length=1000, description="where doors and drawers lie on its front, and so how many; []: only counts"
    )
    mounting: Held | Literal["measured"] | None = Field(None, description="how it is held; measured: geometry tells")
    on: MaskValue | Literal["floor"] | None = Field(None, description="what it stands on")
    size: Size | None = Field(None, description="width along its front, depth, height; metres")
    front: Angle | None = Field(None, description="direction that it faces about z; 0: as the camera looks; radians")
    nudge: tuple[Coordinate, Coordinate] | None = Field(
        None, description="how far it is moved with all that stands on it: away from the camera, to the left; metres"
    )
    model: Id | None = Field(None, description="the asset at rank 1, before those that matching ranked")
    pinned: bool = Field(False, description="`model` stands at every rank")
    banned: list[Id] = Field([], max_length=1000, description="assets that do not stand for it")
    like: MaskValue | None = Field(None, description="the thing whose model it has, at every rank")

    @property
    def outlines(self) -> list[list[Pixel]]:
        """Its outline, and those of its further pieces."""
        return [points for points in (self.outline, *self.pieces) if len(points) > 2]

    @model_validator(mode="after")
    def _one_model(self) -> "Correction":
        check_counts(f"mask {self.mask}", self.panels or [], self.doors, self.drawers)
        check_unique(f"banned of mask {self.mask}", self.banned)
        if self.model is not None and (self.like is not None or self.model in self.banned):
            raise ValueError(f"model: of mask {self.mask} is banned, or that of `like`: say one of them")
        return self


PLACED = {"nudge", "model", "pinned", "banned", "like"}  # read by generation alone
READ: dict[Reader, set[str]] = {"extraction": set(Correction.model_fields) - PLACED - {"mask"}, "generation": PLACED}


class Corrections(Document):
    """`corrections.json`; without it nothing is corrected. Mask values are those of the masks.png beside it."""

    objects: list[Correction] = Field([], max_length=1000)

    @model_validator(mode="after")
    def _check_references(self) -> "Corrections":
        check_unique("objects: mask values", [item.mask for item in self.objects])
        joined = [mask for item in self.objects for mask in item.joins]
        check_unique("objects: masks that are joined", [*joined, *(item.mask for item in self.objects if item.joins)])
        check_supports(self._chain("on"), (FLOOR,))
        check_supports(self._chain("like"), (FLOOR,))
        return self

    def _chain(self, key: str) -> dict[str, str]:
        """From mask value to mask value, as text; a thing of which nothing is stated stands on the floor."""
        stated = {str(item.mask): str(getattr(item, key)) for item in self.objects if getattr(item, key) is not None}
        return {name: FLOOR for name in stated.values() if name != FLOOR} | stated

    def read_by(self, stage: Reader) -> "Corrections":
        """The corrections that concern a stage, no others."""
        kept = [item.model_dump(include={"mask", *READ[stage]}, exclude_defaults=True) for item in self.objects]
        return Corrections(objects=[Correction.model_validate(item) for item in kept if len(item) > 1])


def corrections_of(paths: tuple[Path, ...], stage: Reader) -> dict[int, Correction]:
    """The corrections for a stage, of corrections.json, by mask value; `paths`: the file, or nothing.

    Raises:
        InputError: it is broken.
    """
    found = [read_json(Corrections, path, "mend or delete it").read_by(stage) for path in paths]
    return {item.mask: item for one in found for item in one.objects}
