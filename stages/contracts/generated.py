"""Contract of the `generation` stage: `scene.json`, one per cousin rank."""

from typing import Literal

from pydantic import Field

from stages.contracts.files import Contract
from stages.contracts.library import Vector
from stages.contracts.objects import Mounting, Wall
from stages.contracts.scenes import Matrix


class PlacedObject(Contract):
    """A cousin in its place, in the floor frame."""

    id: str
    label: str
    status: Literal["ok", "failed"] = "ok"
    reason: str = ""
    asset: str = ""
    category: str = ""
    position: Vector = Field((0.0, 0.0, 0.0), description="centre of the asset's box, metres")
    yaw: float = Field(0.0, description="turn of the asset about z, radians")
    size: Vector = Field((0.0, 0.0, 0.0), description="box extents along the asset's own axes, metres")
    support: str = Field("floor", description="'floor', 'wall' or the id of the object beneath")
    mounting: Mounting | None = None
    moved: float = Field(0.0, description="xy distance it was pushed to resolve collisions, metres")
    settled_shift: float | None = Field(None, description="how far it moved in the settling test, metres")


class Plausibility(Contract):
    """Physics check of the scene: load it, let it settle for `seconds`."""

    seconds: float
    stable: bool
    fallen: list[str] = Field(description="objects that dropped or tipped")
    mean_displacement: float
    max_penetration: float
    collisions: int


class GeneratedScene(Contract):
    """`scene.json`: the scene of cousins of one rank, loadable in SAPIEN."""

    version: Literal[1] = 1
    scene: str
    variant: str
    rank: int
    width: int
    height: int
    intrinsics: Matrix
    floor_from_camera: Matrix
    walls: list[Wall]
    objects: list[PlacedObject]
    plausibility: Plausibility | None = None
