"""Contracts of the `scenes` stage: what a camera sees (`input/`) and, apart from it, the truth."""

from typing import Literal

from pydantic import Field

from stages.contracts.files import Contract
from stages.contracts.library import Vector

Matrix = list[list[float]]


class Camera(Contract):
    """`camera.json`: a pinhole camera. Pixel centres are at integer coordinates."""

    version: Literal[1] = 1
    width: int
    height: int
    intrinsics: Matrix = Field(description="3x3 matrix K in pixels")


class Annotation(Contract):
    """What a captioner would say of one object of the image (paper A.2, A.7)."""

    mask: int = Field(description="value of the object's pixels in masks.png; 1 or more")
    label: str = Field(description="free text, e.g. 'cabinet'")
    articulated: bool = False
    doors: int = 0
    drawers: int = 0


class Annotations(Contract):
    """`annotations.json` beside `masks.png` (uint16: 0 nothing, else an object, the floor or a wall)."""

    version: Literal[1] = 1
    objects: list[Annotation]
    floor: int | None = Field(None, description="mask value of the floor")
    walls: list[int] = Field([], description="mask values of the walls")


class TrueObject(Contract):
    """One object of a sim-to-sim room as it really stands."""

    mask: int
    asset: str
    category: str
    position: Vector = Field(description="box centre in the room's world frame, metres")
    yaw: float = Field(description="rotation of the asset about z, radians")
    size: Vector = Field(description="box extents along the asset's axes, metres")
    symmetry: Literal["none", "half_turn", "quarter_turn", "full"]
    support: str = Field(description="'floor', 'wall' or the mask value of the object beneath, as text")


class Truth(Contract):
    """`truth.json`: read by `evaluation` alone."""

    version: Literal[1] = 1
    scene: str
    scale: float = Field(description="largest distance between two box centres, metres (Table 2, 'Scale')")
    world_from_camera: Matrix
    objects: list[TrueObject]
