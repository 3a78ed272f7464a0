"""Intrinsics of a frame: from a file, by the camera's name, or from a field of view."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.recordings import FIELD_OF_VIEW, FIELDS_OF_VIEW
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.errors import suggest_nearest
from roomkin.stages.contracts.types import check_view
from roomkin.stages.geometry.frames import make_intrinsics, scale_intrinsics
from roomkin.stages.perception.read.camera_files import ANGLE, CORNER, FOCAL, KNOWS, MATRICES, find_first, matrix_of
from roomkin.stages.perception.read.frame import is_stretched

Matrix = NDArray[np.float64]
DOWN = ("fy", "fycolor", "fyrgb", "focallengthy")
SIZES = ("resolution", "imagesize", "imgsize", "size")  # [width, height]
NO_PINHOLE = {"omni", "ds", "eucm", "mei", "fov", "equirectangular", "spherical", "panorama", "orthographic", "unread"}


def intrinsics_of_view(degrees: float, width: int, height: int) -> Matrix:
    """K of square pixels with the axis in the middle, from the field of view over the picture's width."""
    low, high = FIELD_OF_VIEW
    if not low <= degrees <= high:
        what, fix = f"is {degrees:g} degrees.", f"{low:g} to {high:g}, over the picture's width"
        raise InputError("--camera", what, fix, code="E-CAMERA-VIEW")
    focal = width / 2 / np.tan(np.deg2rad(degrees) / 2)
    return make_intrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2)


def intrinsics_of_camera(name: str, width: int, height: int) -> Matrix:
    """K of a camera by its name, as its maker describes it: about 2 % off, as single cameras differ. A picture that is
    higher than wide is one of a camera that was held upright."""
    if name not in FIELDS_OF_VIEW:
        fix = f"{suggest_nearest(name, FIELDS_OF_VIEW)} (or {KNOWS})"
        raise InputError("--camera", f"'{name}' is not known.", fix, code="E-CAMERA-NAME")
    across, up = np.tan(np.deg2rad(FIELDS_OF_VIEW[name]) / 2)[:: -1 if height > width else 1]
    focal = max(width / 2 / across, height / 2 / up)
    return make_intrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2)


def find_intrinsics(path: Path, stated: list[float] | dict[str, Any], width: int, height: int) -> Matrix:
    """K for a picture of this size, from what a file states (`contents`), of any usual layout (docs/your-data.md).

    If the file states another size of the same proportions, K is scaled to the picture, which is printed.

    Raises:
        InputError: nothing of the kind, or a camera that cannot have taken a picture of this size.
    """
    try:
        found, size = (
            read_names(path, stated, width, height) if isinstance(stated, dict) else matrix_of(np.array(stated))
        )
    except (ValueError, TypeError, KeyError) as error:
        what = f"holds intrinsics that cannot be read ({error})."
        raise InputError(path, what, KNOWS, code="E-CAMERA-INTRINSICS") from None
    if size is not None and size != (width, height):
        if is_stretched(size, (width, height)):
            what = f"is of {size[0]:g}x{size[1]:g} pixels, the picture has {width}x{height}: other proportions."
            raise InputError(path, what, "intrinsics of this very camera and its proportions", code="E-CAMERA-SIZE")
        print(f"{path}: is of {size[0]:g}x{size[1]:g} pixels, scaled to the picture's {width}x{height}")
        found = scale_intrinsics(found, width / size[0], height / size[1])
    return check_intrinsics(path, found, width, height)


def check_intrinsics(where: object, intrinsics: Matrix, width: int, height: int) -> Matrix:
    """K, checked: whether a camera that took a picture of this size can have it.

    Raises:
        InputError: it cannot.
    """
    try:
        check_view(width, height, intrinsics.tolist())
    except ValueError as error:
        raise InputError(where, f"{error}.", KNOWS, code="E-CAMERA-INTRINSICS") from None
    return intrinsics


def read_names(path: Path, known: dict[str, Any], width: int, height: int) -> tuple[Matrix, tuple[float, float] | None]:
    """K and the size of its picture, if it is stated, from plain names; width, height: of our picture.

    Raises:
        InputError: it holds none, one that is no pinhole camera's, or one of a part of the picture.
        ValueError, TypeError, KeyError: its values are no numbers.
    """
    model = str(find_first(known, "cameramodel", "cameratype", "projection") or "").lower()
    if set(model.replace("_", " ").replace("-", " ").split()) & NO_PINHOLE:
        model = str(known.get("distortionmodel") or model) if model == "unread" else model
        raise InputError(path, f"has the camera model '{model}', which is not read.", KNOWS, code="E-LENS-MODEL")
    roi = known.get("roi")
    if isinstance(roi, dict) and (roi.get("x_offset") or roi.get("y_offset")):
        what = "is of a part of the picture (roi)."
        raise InputError(path, what, "give K of this very picture", code="E-CAMERA-SIZE")
    if float(find_first(known, "skew", "s") or 0):
        raise ValueError(f"a skew of {find_first(known, 'skew', 's')}, which is not read")
    size = _read_size(known)
    if (focal := find_first(known, *FOCAL)) is not None and "flx" not in known:
        cx, cy = (find_first(known, f"c{axis}", f"pp{axis}", f"{axis}offset", f"m{axis}color") for axis in "xy")
        if cx is None or cy is None:
            raise InputError(path, "says fx, but not cx and cy.", KNOWS, code="E-CAMERA-INTRINSICS")
        return make_intrinsics(float(focal), float(find_first(known, *DOWN)), float(cx), float(cy)), size
    if focal is not None or find_first(known, *ANGLE) is not None:
        return _read_nerf(known, *(size or (width, height))), size
    for name in MATRICES:
        value = known.get(name)
        value = value.get("data") if isinstance(value, dict) else value
        if value is not None:
            numbers = value.replace(",", " ").split() if isinstance(value, str) else value
            found, inside = matrix_of(np.asarray(numbers, dtype=float).ravel())
            return found, size or inside
    raise InputError(path, "holds no intrinsics.", KNOWS, code="E-CAMERA-INTRINSICS")


def _read_nerf(known: dict[str, Any], width: float, height: float) -> Matrix:
    """K of a transforms.json, whose focal length may be an angle, with the axis in the middle if none is stated."""
    radians = known["cameraanglex"] if "cameraanglex" in known else np.deg2rad(float(find_first(known, *ANGLE) or 0))
    across = float(known["flx"]) if "flx" in known else width / 2 / np.tan(float(radians) / 2)
    cx, cy = float(known.get("cx", width / 2)), float(known.get("cy", height / 2))
    return make_intrinsics(across, float(known.get("fly", across)), cx - CORNER, cy - CORNER)


def _read_size(known: dict[str, Any]) -> tuple[float, float] | None:
    """Width and height of the picture in plain names."""
    names = (("{}", "image{}", "img{}", "color{}", "rgb{}", "sensor{}"), ("width", "height"))
    width, height = (find_first(known, *(name.format(side) for name in names[0]), side[0]) for side in names[1])
    if width is None or height is None:
        both = find_first(known, *SIZES)
        width, height = both if isinstance(both, (list, tuple)) and len(both) == 2 else (None, None)
    return (float(width), float(height)) if width and height else None
