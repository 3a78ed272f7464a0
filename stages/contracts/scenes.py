"""Contracts of the `scenes` stage: what a camera sees (`input/`) and, apart from it, the truth."""

from operator import not_
from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts import types
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, Document, read_json
from roomkin.stages.contracts.library import Symmetry
from roomkin.stages.contracts.objects import Box, Objects
from roomkin.stages.contracts.parts import Panel, check_counts
from roomkin.stages.contracts.things import Name


class Camera(Document):
    """`camera.json`: a pinhole camera. Pixel centers are at integer coordinates."""

    width: types.Side = Field(description="of the upright picture, as a viewer shows it")
    height: types.Side
    intrinsics: types.CameraMatrix = Field(description="3x3 matrix K in pixels")
    # Where the camera stands over the floor, if that is known (see Objects); else it is fitted.
    floor_from_camera: types.RigidTransform | None = None
    note: str = Field("", max_length=1000, description="for people: where the focal length is from")
    # For people: what its file is called, without its ending; empty: as the folder.
    picture: str = Field("", max_length=1000, exclude_if=not_)
    digest: str = Field(
        "", pattern="^([0-9a-f]{64})?$", exclude_if=not_, description="SHA-256 of the picture's file; empty: of rgb.png"
    )

    @model_validator(mode="after")
    def _check_view(self) -> "Camera":
        types.check_view(self.width, self.height, self.intrinsics)
        if self.floor_from_camera is not None and self.floor_from_camera[2][3] <= 0:
            raise ValueError("floor_from_camera: the camera is not above the floor: z is up")
        return self


class Held(Contract):
    """Paper A.2: 1 wall mounted, 2 on the floor or on another object, 3 mixture (stands, and touches a wall)."""

    type: Literal[1, 2, 3]
    walls: list[types.MaskValue] = Field([], description="mask values of the walls touched, the dominant one first")

    @model_validator(mode="after")
    def _check_walls(self) -> "Held":
        types.check_unique("mounting.walls", self.walls)
        if (self.type == 2) == bool(self.walls):
            raise ValueError("mounting.walls: types 1 and 3 name their walls, type 2 names none")
        return self


class Annotation(Contract):
    """The caption of one object of the image (paper A.2, A.7)."""

    mask: types.MaskValue = Field(description="value of the object's pixels in masks.png; 1 or more")
    label: types.Text = Field(description="free text, e.g. 'cabinet'")
    articulated: bool = Field(False, description="whether it opens; what has doors or drawers does")
    doors: types.Panels = 0
    drawers: types.Panels = 0
    panels: list[Panel] = Field([], max_length=1000, description="where they lie on its front; empty: not known")
    mounting: Held | None = Field(None, description="how it is held, if that is known; else geometry tells")
    box: Box | None = Field(
        None, description="where it is known whole, hidden sides too: needs floor_from_camera in camera.json"
    )
    guessed: bool = Field(False, description="how deep `box` is nobody saw or said: the models' proportions tell")
    front: types.Angle | None = Field(
        None, description="direction that it faces about z, in the floor frame; what has a `box` and none is round"
    )
    doubts: list[Doubt] = Field(
        [],
        exclude_if=not_,
        description="of its name, if proposed; what of `box` was guessed or put right, as drawn by hand",
    )
    proposals: list[types.Text] = Field([], max_length=10, exclude_if=not_, description="names of it, the surest first")
    probabilities: list[types.Fraction] = Field([], exclude_if=not_, description="of these; empty: label is certain")

    @property
    def names(self) -> list[Name]:
        """The names that it may have with their probabilities; empty: its label is certain."""
        pairs = zip(self.proposals, self.probabilities, strict=False)
        return [Name(name=name, probability=probability) for name, probability in pairs]

    @model_validator(mode="after")
    def _check_names(self) -> "Annotation":
        if self.probabilities and len(self.probabilities) != len(self.proposals):
            raise ValueError(f"probabilities: {len(self.probabilities)} for {len(self.proposals)} proposals")
        return self

    @model_validator(mode="after")
    def _check_fronts(self) -> "Annotation":
        if self.doors + self.drawers and not self.articulated:
            raise ValueError(f"articulated: is false, but '{self.label}' has doors or drawers")
        check_counts(self.label, self.panels, self.doors, self.drawers)
        return self


class Annotations(Document):
    """`annotations.json` beside `masks.png` (uint16: 0 nothing, else an object, the floor or a wall)."""

    objects: list[Annotation] = Field(min_length=1)
    floor: types.MaskValue | None = Field(None, description="mask value of the floor")
    walls: list[types.MaskValue] = Field([], description="mask values of the walls")

    @property
    def values(self) -> list[int]:
        """All mask values that have a meaning."""
        floor = [] if self.floor is None else [self.floor]
        return [item.mask for item in self.objects] + self.walls + floor

    @model_validator(mode="after")
    def _values_once(self) -> "Annotations":
        types.check_unique("mask values", self.values)
        for item in self.objects:
            if strangers := set(item.mounting.walls if item.mounting else []) - set(self.walls):
                raise ValueError(f"objects: mounting.walls of mask {item.mask}: {min(strangers)} is not in walls")
        return self


class TrueObject(Contract):
    """One object of a sim-to-sim room as it really stands."""

    mask: types.MaskValue
    asset: types.Id
    category: types.Id
    position: types.Position = Field(description="box center in the room's world frame, metres")
    yaw: types.Angle = Field(description="rotation of the asset about z, radians")
    size: types.Size = Field(description="box extents along the asset's axes, metres")
    symmetry: Symmetry
    support: str = Field(description="'floor', 'wall' or the mask value of the object beneath, as text")


class Truth(Document):
    """`truth.json`: read by `evaluation`, and by the policy experiment, whose twin is the true model of its object."""

    scene: types.SceneName
    scale: types.Extent = Field(description="largest distance between two box centers, metres (Table 2, 'Scale')")
    world_from_camera: types.RigidTransform
    objects: list[TrueObject] = Field(min_length=1)

    @model_validator(mode="after")
    def _check_masks(self) -> "Truth":
        types.check_unique("objects: mask values", [item.mask for item in self.objects])
        types.check_supports({str(item.mask): item.support for item in self.objects})
        return self


def find_true_model(truth: Path | None, objects: Path | None, object: str) -> str | None:
    """Id of the true model of a named object; None without a truth, or if the truth does not know the object.

    Args:
        truth: truth.json of the room.
        objects: objects.json of extraction, of the same room.
        object: id of the object in objects.json.

    Raises:
        InputError: one file was given without the other, or they are of different rooms.
    """
    if truth is None and objects is None:
        return None
    if truth is None or objects is None:
        what = "one is given without the other."
        raise InputError("--truth, --objects", what, "give both or neither", code="E-FLAG-ALONE")
    true, seen = read_json(Truth, truth), read_json(Objects, objects)
    if true.scene != seen.scene:
        raise InputError(truth, f"is of {true.scene}, but {objects} of {seen.scene}.", code="E-SCENE-MIXED")
    mask = next((item.mask for item in seen.objects if item.id == object), None)
    return next((item.asset for item in true.objects if item.mask == mask), None)
