"""Read depth from PNG, TIFF, PGM, EXR, NPZ and NPY, and find out whether it is in metres or millimetres."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from stages.contracts import InputError
from stages.contracts.arrays import read_npz, readable
from stages.contracts.depth import NEAREST, SKY, check_depth
from stages.contracts.types import LARGEST

MEASURED = 6.0  # metres: the median depth of frames of cameras is less; more in millimetres is another unit, mostly
IMAGES = (".png", ".tif", ".tiff", ".pgm")
FILES = (*IMAGES, ".exr", ".npz", ".npy")
UNITS = {"m": 1.0, "mm": 1000.0}


def read_raw(path: Path) -> NDArray[Any]:
    """The numbers (h, w) of a depth file, in its own unit.

    Raises:
        InputError: no depth: missing, of another format, in colours, or with 8 bits.
    """
    if path.suffix.lower() not in FILES:
        raise InputError(
            path, "is no kind of depth file that is known.", f"one of {', '.join(FILES)}", code="E-DEPTH-FORMAT"
        )
    with readable(path, "depth file"):
        if path.suffix.lower() in IMAGES:
            array = _from_image(path)
        elif path.suffix.lower() == ".exr":
            array = _from_exr(path)
        else:
            array = _from_numpy(path)
    array = array[..., 0] if array.ndim == 3 and array.shape[2] == 1 else array
    if array.ndim != 2 or 0 in array.shape or array.dtype.kind not in "fiu":
        raise InputError(
            path,
            f"has shape {array.shape} and type {array.dtype}: it is no depth image.",
            "store one array (height, width) of numbers, called depth",
            code="E-DEPTH-FORMAT",
        )
    return array


def _from_image(path: Path) -> NDArray[Any]:
    with Image.open(path, formats=("PNG", "TIFF", "PPM")) as image:
        if image.mode not in ("I;16", "I;16B", "I;16L", "I;16N", "I", "F"):
            what = f"has {8 * len(image.getbands())} bits per pixel ({image.mode}): a picture of depth, not depth."
            raise InputError(path, what, "export depth with 16 bits per pixel, or as floats", code="E-DEPTH-FORMAT")
        return np.asarray(image)


def _from_exr(path: Path) -> NDArray[Any]:
    try:
        import OpenEXR
    except ImportError:
        raise InputError(
            path, "is an EXR file, which nothing installed here reads.", "pip install OpenEXR", code="E-LIBRARY-MISSING"
        ) from None
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        name = next((name for name in ("Z", "depth.Z", "R", "Y", "V") if name in channels), None) or min(channels)
        return np.array(channels[name].pixels)


def _from_numpy(path: Path) -> NDArray[Any]:
    if path.suffix.lower() == ".npy":
        return np.asarray(np.load(path, allow_pickle=False))
    arrays = read_npz(path)
    if "depth" in arrays or len(arrays) == 1:
        return arrays.get("depth", next(iter(arrays.values())))
    raise InputError(
        path,
        f"holds {', '.join(arrays)}, and none of them is called depth.",
        "store one array (height, width) of numbers, called depth",
        code="E-DEPTH-FORMAT",
    )


def in_metres(path: Path, raw: NDArray[Any], unit: str = "auto") -> tuple[NDArray[np.float32], str]:
    """Depth in metres (h, w), 0: unknown, and a line that says which unit was found.

    Args:
        path: for errors.
        raw: numbers as stored; what is negative, not finite or beyond 100 m is unknown.
        unit: auto, m, mm, or the number that stands for one metre, e.g. 5000 (TUM).

    Raises:
        InputError: no pixel is known, or the numbers are no depth of a room in this unit, or in any.
    """
    known = raw[np.isfinite(raw) & (raw > 0)]
    if not known.size:
        raise InputError(
            path, "no pixel has a depth above 0.", "check how the camera saves depth", code="E-DEPTH-EMPTY"
        )
    median = float(np.median(known))
    per_metre = _guessed(path, median, raw.dtype.kind in "iu") if unit == "auto" else _given(unit)
    if not NEAREST <= median / per_metre <= LARGEST:
        what = f"has the median {median:g}, which would be {median / per_metre:.3g} m: no room."
        raise InputError(
            path, what, "another --unit: m, mm, or the number that stands for one metre", code="E-DEPTH-UNIT"
        )
    metres = np.where(np.isfinite(raw), raw, 0).astype(np.float64) / per_metre
    metres[(metres < 0) | (metres > SKY)] = 0
    check_depth(path, metres)
    name = next((name for name, number in UNITS.items() if number == per_metre), f"1/{per_metre:g} m")
    how = "found by its median" if unit == "auto" else "as told"
    line = f"depth in {name} ({how}, {median / per_metre:.2f} m), known on {100 * (metres > 0).mean():.0f} % of it"
    return metres.astype(np.float32), line


def _guessed(path: Path, median: float, whole: bool) -> float:
    if not whole and NEAREST <= median <= LARGEST:
        return UNITS["m"]
    if 1000 * NEAREST <= median <= 1000 * MEASURED:
        return UNITS["mm"]
    if 1000 * MEASURED < median <= 1000 * LARGEST:
        what = f"has the median {median:g}: {median / 1000:.3g} m in millimetres, {median / 5000:.3g} m in 1/5000 m."
        raise InputError(
            path,
            what,
            "say which it is: --unit mm, --unit 5000, or the number that stands for one metre",
            code="E-DEPTH-UNIT",
        )
    what = f"has the median {median:.3g}, which is neither metres nor millimetres of a room."
    raise InputError(
        path, what, "say the unit with --unit: m, mm, or the number that stands for one metre", code="E-DEPTH-UNIT"
    )


def _given(unit: str) -> float:
    try:
        per_metre = UNITS.get(unit) or float(unit)
    except ValueError:
        per_metre = 0.0
    if not np.isfinite(per_metre) or per_metre <= 0:
        raise InputError(
            "--unit",
            f"is '{unit}'.",
            "auto, m, mm, or the number that stands for one metre, e.g. 5000",
            code="E-DEPTH-UNIT",
        )
    return per_metre
