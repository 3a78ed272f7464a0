"""Contract of the `extraction` stage: `objects.json` and the arrays beside it."""

from typing import Literal

from pydantic import Field

from stages.contracts.files import Contract
from stages.contracts.library import Vector
from stages.contracts.scenes import Matrix


class Wall(Contract):
    """A wall plane in the floor frame: points p with normal . p = offset; the normal is horizontal and faces us."""

    id: str
    normal: Vector
    offset: float
    points: int


class Box(Contract):
    """A z-aligned box in the floor frame; `size` is (x, y, z) along the box's own axes, `yaw` in (-pi/4, pi/4]."""

    center: Vector
    size: Vector
    yaw: float


class Mounting(Contract):
    """Paper A.2: 1 wall mounted, 2 on the floor or on another object, 3 mixture (stands, and touches a wall)."""

    type: Literal[1, 2, 3]
    walls: list[str] = Field([], description="ids of the walls touched, the dominant one first")


class SceneObject(Contract):
    """One object of the image."""

    id: str = Field(description="label and running number, e.g. cabinet_1; unique within the scene")
    label: str
    mask: int = Field(description="value of its pixels in masks.png")
    status: Literal["ok", "failed"] = "ok"
    reason: str = Field("", description="why it failed")
    pixels: tuple[int, int, int, int] | None = Field(None, description="mask bounds x0, y0, x1, y1 (exclusive)")
    articulated: bool = False
    doors: int = 0
    drawers: int = 0
    points: int = 0
    box: Box | None = Field(None, description="z-aligned minimum box of the cleaned cloud (null if failed)")
    mounting: Mounting | None = None


class Objects(Contract):
    """`objects.json`. Beside it: `masks.png` (uint16, cleaned masks in full-image pixels), `depth.npz`
    (`depth` float32 metres, 0: unknown), `clouds.npz` (one (N, 3) float32 array per object id, floor frame).

    The floor frame: z = 0 on the floor and up along its normal, origin below the camera,
    x along the horizontal part of the viewing direction.
    """

    version: Literal[1] = 1
    scene: str
    width: int
    height: int
    intrinsics: Matrix
    floor_from_camera: Matrix
    walls: list[Wall]
    objects: list[SceneObject]
