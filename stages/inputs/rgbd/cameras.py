"""Intrinsics of a frame: from a file, by the camera's name, or from a field of view."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from stages.config.cameras import FIELD_OF_VIEW, FIELDS_OF_VIEW
from stages.contracts import InputError
from stages.contracts.arrays import readable
from stages.contracts.types import check_view
from stages.inputs.rgbd.frame import is_stretched

Matrix = NDArray[np.float64]

DEEPER = ("color", "rgb", "color_intrinsics", "rgb_intrinsics", "intrinsic", "intrinsics", "camera", "cam0")
KNOWS = "a file with fx, fy, cx, cy or a 3x3 matrix (JSON, YAML, text, NPY), see docs/your-data.md"


def matrix(fx: float, fy: float, cx: float, cy: float) -> Matrix:
    """K (3, 3)."""
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def resized(intrinsics: Matrix, width: float, height: float) -> Matrix:
    """K after the picture is made `width` and `height` times as large; pixel centres are at integer coordinates."""
    (fx, _, cx), (_, fy, cy), _ = intrinsics
    return matrix(fx * width, fy * height, (cx + 0.5) * width - 0.5, (cy + 0.5) * height - 0.5)


def of_field_of_view(degrees: float, width: int, height: int) -> Matrix:
    """K of square pixels with the axis in the middle, from the field of view over the picture's width."""
    low, high = FIELD_OF_VIEW
    if not low <= degrees <= high:
        what, fix = f"is {degrees:g} degrees.", f"{low:g} to {high:g}, over the picture's width"
        raise InputError("--fov", what, fix, code="E-CAMERA-VIEW")
    focal = width / 2 / np.tan(np.deg2rad(degrees) / 2)
    return matrix(focal, focal, (width - 1) / 2, (height - 1) / 2)


def of_camera(name: str, width: int, height: int) -> Matrix:
    """K of a camera by its name, as its maker describes it: about 2 % off, as single cameras differ."""
    if name not in FIELDS_OF_VIEW:
        raise InputError(
            "--camera",
            f"'{name}' is not known.",
            f"one of {', '.join(FIELDS_OF_VIEW)}; or --intrinsics: {KNOWS}",
            code="E-CAMERA-NAME",
        )
    across, up = np.tan(np.deg2rad(FIELDS_OF_VIEW[name]) / 2)
    focal = max(width / 2 / across, height / 2 / up)
    return matrix(focal, focal, (width - 1) / 2, (height - 1) / 2)


def read_intrinsics(path: Path, width: int, height: int) -> Matrix:
    """K for a picture of this size, from a file of any usual layout.

    Known: `fx fy cx cy` or nine numbers as text; JSON or YAML with fx, fy, cx, cy (ppx, x_offset), with `intrinsics`,
    `K`, `camera_matrix` or `intrinsic_matrix` as rows, as nine numbers in either order, or as {data: nine numbers}.
    Where the file says width and height, K is scaled to the picture.

    Raises:
        InputError: nothing of the kind, or a camera that cannot have taken a picture of this size.
    """
    told = contents(path)
    found, size = of_mapping(path, told) if isinstance(told, dict) else (told, None)
    if size is not None and size != (width, height):
        if is_stretched(size, (width, height)):
            what = f"is of {size[0]:g}x{size[1]:g} pixels, the picture has {width}x{height}: other proportions."
            raise InputError(path, what, "intrinsics of this very camera and its proportions", code="E-CAMERA-SIZE")
        found = resized(found, width / size[0], height / size[1])
    return checked(path, found, width, height)


def checked(where: object, intrinsics: Matrix, width: int, height: int) -> Matrix:
    """K, if a camera that took a picture of this size can have it.

    Raises:
        InputError: it cannot.
    """
    try:
        check_view(width, height, intrinsics.tolist())
    except ValueError as error:
        raise InputError(where, f"{error}.", KNOWS, code="E-CAMERA-INTRINSICS") from None
    return intrinsics


def contents(path: Path) -> Matrix | dict[str, Any]:
    """What a file of intrinsics says: K in plain numbers, or names (in small letters) and their values.

    Raises:
        InputError: neither.
    """
    if path.suffix.lower() == ".npy":
        with readable(path, "file of intrinsics", KNOWS):
            return _matrix_of(np.load(path, allow_pickle=False).astype(float).ravel().tolist())
    with readable(path, "file of intrinsics", KNOWS):
        text = path.read_text(encoding="utf-8-sig")
    words = text.replace(",", " ").replace(";", " ").replace("[", " ").replace("]", " ").split()
    try:
        return _matrix_of([float(word) for word in words])
    except (ValueError, TypeError):
        pass
    with readable(path, "file of intrinsics", KNOWS):
        data = json.loads(text) if text.lstrip().startswith("{") else yaml.safe_load(text.replace("%YAML:1.0", ""))
    if not isinstance(data, dict):
        raise InputError(path, "holds no intrinsics.", KNOWS, code="E-CAMERA-INTRINSICS")
    return flat(data)


def flat(data: dict[str, Any]) -> dict[str, Any]:
    """Names in small letters; what is said of the colour camera one level deeper, too."""
    known = {str(key).lower(): value for key, value in data.items()}
    for key in DEEPER:
        if isinstance(known.get(key), dict):
            known = {str(name).lower(): value for name, value in known[key].items()} | known
    return known


def of_mapping(path: Path, data: dict[str, Any]) -> tuple[Matrix, tuple[float, float] | None]:
    """K and the size of the picture, if it is told, from the contents of a JSON or YAML file.

    Raises:
        InputError: it holds none.
    """
    known = flat(data)
    width, height = (_first(known, name, f"image_{name}", f"img_{name}", name[0]) for name in ("width", "height"))
    size = (float(width), float(height)) if width and height else None
    try:
        if "fx" in known:
            fx, fy = known["fx"], known["fy"]
            cx, cy = (_first(known, f"c{axis}", f"pp{axis}", f"{axis}_offset") for axis in "xy")
            if cx is None or cy is None:
                raise InputError(path, "says fx, but not cx and cy.", KNOWS, code="E-CAMERA-INTRINSICS")
            return matrix(float(fx), float(fy), float(cx), float(cy)), size
        for name in ("intrinsics", "k", "camera_matrix", "intrinsic_matrix", "cam_k"):
            if name in known:
                value = known[name]["data"] if isinstance(known[name], dict) else known[name]
                return _matrix_of(np.asarray(value, dtype=float).ravel().tolist()), size
    except (ValueError, TypeError, KeyError) as error:
        raise InputError(
            path, f"holds intrinsics that cannot be read ({error}).", KNOWS, code="E-CAMERA-INTRINSICS"
        ) from None
    raise InputError(path, "holds no intrinsics.", KNOWS, code="E-CAMERA-INTRINSICS")


def _first(known: dict[str, Any], *names: str) -> Any:
    """What stands under the first of the names that is there."""
    return next((known[name] for name in names if name in known), None)


def _matrix_of(numbers: list[float]) -> Matrix:
    """Four numbers (fx, fy, cx, cy), or nine, row by row or column by column."""
    if len(numbers) == 4:
        return matrix(*numbers)
    square = np.array(numbers).reshape(3, 3)
    square = square.T if square[2, 0] > 1 else square
    if square[2].tolist() != [0.0, 0.0, 1.0]:
        raise ValueError("the last row is not 0 0 1")
    return matrix(square[0, 0], square[1, 1], square[0, 2], square[1, 2])
