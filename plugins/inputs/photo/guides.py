"""Evidence about the camera: lines of known direction, and values fixed by hand. Upright picture's pixels."""

from typing import Annotated, Literal

from pydantic import Field

from stages.contracts.files import Contract
from stages.contracts.types import Pixel

Focal = Annotated[float, Field(gt=10, lt=1e5, allow_inf_nan=False)]
Axis = Literal["x", "y", "z"]


class Guide(Contract):
    """A line in the picture that in the room runs along an axis: x along the view's wall, y away from us, z up."""

    axis: Axis
    a: Pixel
    b: Pixel


class Perspective(Contract):
    """What determines the camera: lines, and values fixed by hand (null: fitted to the lines)."""

    guides: list[Guide] = Field([], max_length=200)
    horizon: tuple[Pixel, Pixel] | None = None
    x: Pixel | None = None
    y: Pixel | None = None
    z: Pixel | None = None
    focal: Focal | None = Field(None, description="pixels, fixed by hand")
    likely_focal: Focal = Field(description="pixels: from EXIF, from all lines found, or that of a usual camera")
    spread: float = Field(0.3, gt=0, le=2, description="standard deviation of the logarithm of `likely_focal`")
