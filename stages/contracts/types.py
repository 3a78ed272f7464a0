"""The kinds of values that contract files hold: shaped, finite and bounded. Pure Python, so that start-up stays cheap.

Bounds are far beyond any room; a value outside is in another unit (millimetres, degrees) or broken.
"""

import math
from collections.abc import Hashable, Iterable
from pathlib import PurePosixPath
from typing import Annotated

from pydantic import AfterValidator, Field

LARGEST = 30.0  # metres: extent of the largest object
FARTHEST = 1000.0  # metres: of a position from its origin
FLOOR, WALL, UNNAMED = "floor", "wall", "unnamed"  # what carries an object, besides another; no object has such an id
RIGID_TOLERANCE = 1e-3  # of R^T R against the identity: matrices written with four digits pass


def _require_within(low: float, high: float, what: str) -> AfterValidator:
    def check(value: float) -> float:
        if not (math.isfinite(value) and low <= value <= high):
            raise ValueError(f"{value:g} is no {what} ({low:g} to {high:g})")
        return value

    return AfterValidator(check)


Finite = Annotated[float, Field(allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Extent = Annotated[float, _require_within(1e-6, LARGEST, "extent in metres")]
Length = Annotated[float, _require_within(1e-3, LARGEST, "length in metres")]  # that a person says of a thing
Coordinate = Annotated[float, _require_within(-FARTHEST, FARTHEST, "coordinate in metres")]
Angle = Annotated[float, _require_within(-10.0, 10.0, "angle in radians")]
Mass = Annotated[float, _require_within(1e-6, 1e5, "mass in kg")]
Count = Annotated[int, Field(ge=0, le=10**9)]
Panels = Annotated[int, Field(ge=0, le=1000, description="doors or drawers of one object")]
Rank = Annotated[int, Field(ge=1, le=1000)]
Seed = Annotated[int, Field(ge=0, lt=2**63)]
MaskValue = Annotated[int, Field(ge=1, le=65535)]
Side = Annotated[int, Field(ge=1, le=20_000, description="pixels")]

Id = Annotated[str, Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.-]*$", max_length=200)]
SceneName = Annotated[str, Field(pattern=r"^[\p{L}\p{M}\p{N}_][\p{L}\p{M}\p{N}_.-]*$", max_length=200)]
Text = Annotated[str, Field(min_length=1, max_length=1000)]


def _check_confined(text: str) -> str:
    """A path that cannot leave the folder it is relative to."""
    path = PurePosixPath(text)
    if not text or path.is_absolute() or ".." in path.parts or "\\" in text or ":" in text or not text.isprintable():
        raise ValueError(f"{text!r} is no relative path inside the folder of this file")
    return text


RelativePath = Annotated[str, AfterValidator(_check_confined), Field(max_length=1000)]

Vector = tuple[Finite, Finite, Finite]
Position = tuple[Coordinate, Coordinate, Coordinate]
PixelCoordinate = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]  # vanishing points may lie far outside
Pixel = tuple[PixelCoordinate, PixelCoordinate]
Outline = Annotated[list[Pixel], Field(max_length=1000)]
Size = tuple[Extent, Extent, Extent]


def _unit(vector: Vector) -> Vector:
    length = math.hypot(*vector)
    if abs(length - 1) > RIGID_TOLERANCE:
        raise ValueError(f"is no unit vector: its length is {length:g}")
    return vector


def _horizontal(vector: Vector) -> Vector:
    if abs(vector[2]) > RIGID_TOLERANCE:
        raise ValueError("is not horizontal: its z is not 0")
    return vector


UnitVector = Annotated[Vector, AfterValidator(_unit)]
HorizontalUnitVector = Annotated[UnitVector, AfterValidator(_horizontal)]

Matrix = list[list[Finite]]  # rows


def _rigid(matrix: Matrix) -> Matrix:
    if len(matrix) != 4 or any(len(row) != 4 for row in matrix):
        raise ValueError("is not a 4x4 matrix")
    if matrix[3] != [0, 0, 0, 1]:
        raise ValueError("is no rigid transform: the last row must be [0, 0, 0, 1]")
    (a, b, c), (d, e, f), (g, h, i) = (row[:3] for row in matrix[:3])
    columns = list(zip(*(row[:3] for row in matrix[:3]), strict=True))
    for j, one in enumerate(columns):
        for k, other in enumerate(columns):
            if abs(sum(x * y for x, y in zip(one, other, strict=True)) - (j == k)) > RIGID_TOLERANCE:
                raise ValueError("is no rigid transform: its 3x3 part is no rotation")
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0:
        raise ValueError("is no rigid transform: it mirrors (determinant -1)")
    if any(abs(row[3]) > FARTHEST for row in matrix[:3]):
        raise ValueError(f"moves farther than {FARTHEST:g} m: write metres")
    return matrix


def _camera_matrix(matrix: Matrix) -> Matrix:
    mend = "write [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels"
    if len(matrix) != 3 or any(len(row) != 3 for row in matrix):
        raise ValueError(f"is not a 3x3 matrix: {mend}")
    (fx, skew, cx), (below, fy, cy), last = matrix
    if last != [0, 0, 1] or below != 0 or skew != 0 or not (0 < fx < 1e6 and 0 < fy < 1e6):
        raise ValueError(f"is not a camera matrix: {mend}")
    if max(abs(cx), abs(cy)) > 1e5:
        raise ValueError(f"has its principal point at {cx:g}, {cy:g}: {mend}")
    return matrix


RigidTransform = Annotated[Matrix, AfterValidator(_rigid)]
CameraMatrix = Annotated[Matrix, AfterValidator(_camera_matrix)]


ALIKE, SMALLER = 0.1, 0.25  # shares of a picture's sides by which the center of a picture of another size may be off


def check_view(width: int, height: int, intrinsics: Matrix) -> None:
    """Refuse a camera that cannot have taken a picture of this size: 3 to 136 degrees, nearly square pixels, an axis
    near the middle. So a matrix in shares of the picture, or of another picture size, is found.
    """
    (fx, _, cx), (_, fy, cy), _ = intrinsics
    if not (0.2 * width < fx < 20 * width and 0.7 * fy < fx < 1.4 * fy):
        what = f"fx {fx:g}, fy {fy:g} are not those of a picture of {width}x{height} pixels"
        raise ValueError(f"intrinsics: {what}: write them in its pixels")
    if not (0.2 * width < cx < 0.8 * width and 0.2 * height < cy < 0.8 * height):
        what = f"cx {cx:g}, cy {cy:g} are far from the middle of {width}x{height} pixels"
        raise ValueError(f"intrinsics: {what}: write those of this picture size, in pixels")
    across, down = (2 * cx + 1) / width, (2 * cy + 1) / height
    if abs(across - down) < ALIKE and abs(across - 1) > SMALLER:
        what = f"cx {cx:g}, cy {cy:g} are in the middle of {across * width:.0f}x{down * height:.0f} pixels"
        raise ValueError(f"intrinsics: {what}, the picture has {width}x{height}: write those of this picture size")


def check_unique(what: str, values: Iterable[Hashable]) -> None:
    """Refuse values that occur twice."""
    seen: set[Hashable] = set()
    for value in values:
        if value in seen:
            raise ValueError(f"{what}: {value!r} occurs twice")
        seen.add(value)


def check_supports(supports: dict[str, str], fixed: tuple[str, ...] = ("floor", "wall")) -> None:
    """Refuse supports (id -> id beneath, 'floor' or 'wall') that do not exist or go round in a circle."""
    for name, below in supports.items():
        seen = {name}
        while below not in fixed:
            if below not in supports:
                raise ValueError(f"objects: the support of '{name}' is '{below}', which is not there")
            if below in seen:
                raise ValueError(f"objects: '{name}' is carried by itself (supports go round in a circle)")
            seen.add(below)
            below = supports[below]
