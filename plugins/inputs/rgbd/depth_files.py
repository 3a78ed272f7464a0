"""Read depth from PNG, TIFF, PGM, EXR, NPZ and NPY, and find out whether it is in metres or millimetres."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from plugins.inputs.rgbd.depth_scale import UNITS, Stated, find_scale
from plugins.inputs.rgbd.exr import read_exr
from stages.contracts import InputError
from stages.contracts.arrays import explain_unreadable, read_npz
from stages.contracts.depth import NEAREST, SKY, check_depth
from stages.contracts.types import LARGEST
from stages.geometry.depth_marks import MIN_PIXELS, MIN_VALUES, count_values, find_marks, remove_marks

DEPTH_IMAGES = (".png", ".tif", ".tiff", ".pgm")
DEPTH_FILES = (*DEPTH_IMAGES, ".exr", ".npz", ".npy")
# Chosen; what they find on frames of cameras is in docs/results/your-data.md.
CUT_TIMES, CUT_SHARE = 20, 0.002  # times the pixels of any nearby value, and share of all, at the end of the range
NEARBY = 0.9  # share of the range from which on values are nearby
MIN_RANGE = 2.0  # metres: no camera's range is shorter


def read_raw(path: Path) -> NDArray[Any]:
    """The numbers (h, w) of a depth file, in its own unit.

    Raises:
        InputError: no depth: missing, of another format, in colors, or with 8 bits.
    """
    if path.suffix.lower() not in DEPTH_FILES:
        raise InputError(
            path, "is no kind of depth file that is known.", f"one of {', '.join(DEPTH_FILES)}", code="E-DEPTH-FORMAT"
        )
    with explain_unreadable(path, "depth file"):
        if path.suffix.lower() in DEPTH_IMAGES:
            array = _read_image(path)
        else:
            array = _read_numpy(path) if path.suffix.lower() != ".exr" else read_exr(path)
    array = array[..., 0] if array.ndim == 3 and array.shape[2] == 1 else array
    if array.ndim != 2 or 0 in array.shape or array.dtype.kind not in "fiu" or array.dtype.itemsize == 1:
        raise InputError(
            path,
            f"has shape {array.shape} and type {array.dtype}: it is no depth image.",
            "store one array (height, width) of numbers with 16 bits or more, called depth",
            code="E-DEPTH-FORMAT",
        )
    return array


def _read_image(path: Path) -> NDArray[Any]:
    with Image.open(path, formats=("PNG", "TIFF", "PPM")) as image:
        if (pages := getattr(image, "n_frames", 1)) > 1:
            what = f"has {pages} pages: which of them is depth?"
            raise InputError(path, what, "save the one of depth alone", code="E-DEPTH-FORMAT")
        if image.mode not in ("I;16", "I;16B", "I;16L", "I;16N", "I", "F"):
            what = f"has {8 * len(image.getbands())} bits per pixel ({image.mode}): a picture of depth, not depth."
            raise InputError(path, what, "export depth with 16 bits per pixel, or as floats", code="E-DEPTH-FORMAT")
        numbers = np.asarray(ImageOps.exif_transpose(image))
        if image.format != "PPM":
            return numbers
        return np.rint(numbers * (_largest_of_pgm(path) / 65535)).astype(np.int32)  # Pillow scales them to 65535


def _largest_of_pgm(path: Path) -> int:
    """The fourth word of the header, of which comments are no part."""
    with path.open("rb") as file:
        head = re.sub(rb"#[^\n]*", b"", file.read(1000))
    return int(head.split()[3])


def _read_numpy(path: Path) -> NDArray[Any]:
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


def convert_to_metres(
    path: Path, raw: NDArray[Any], unit: str = "auto", stated: Sequence[Stated] = (), usual: float | None = None
) -> tuple[NDArray[np.float32], str]:
    """Depth in metres (h, w), 0: unknown, and a line with the unit and its source.

    Args:
        path: for errors.
        raw: numbers as stored; what is negative, not finite, beyond 100 m or a mark of `depth_marks` is unknown.
        unit: auto, m, mm, or the number that stands for one metre, e.g. 5000 (TUM).
        stated: what files say of the unit.
        usual: the number that stands for one metre if nobody states one, if it is known; else the median decides.

    Raises:
        InputError: no pixel is known, or the numbers are no depth of a room in this unit, or in any.
    """
    marks = find_marks(raw)
    raw = remove_marks(raw, marks)
    known = raw[np.isfinite(raw) & (raw > 0)]
    if not known.size:
        raise InputError(
            path, "no pixel has a depth above 0.", "check how the camera saves depth", code="E-DEPTH-EMPTY"
        )
    median = float(np.median(known))
    per_metre, how = find_scale(path, known, unit, stated, usual)
    if not NEAREST <= median / per_metre <= LARGEST:
        what = f"has the median {median:g}, which would be {median / per_metre:.3g} m: no room."
        raise InputError(
            path, what, "another --unit: m, mm, or the number that stands for one metre", code="E-DEPTH-UNIT"
        )
    metres = np.where(np.isfinite(raw), raw, 0).astype(np.float64) / per_metre
    metres[(metres < 0) | (metres > SKY)] = 0
    if (cut := find_cut_range(metres)) is not None:
        metres[metres == cut] = 0
        marks.append(cut * per_metre)
    check_depth(path, metres)
    name = next((name for name, number in UNITS.items() if number == per_metre), f"1/{per_metre:g} m")
    line = f"depth in {name} ({how}, {median / per_metre:.2f} m), known on {100 * (metres > 0).mean():.0f} % of it"
    if marks:
        line += f", {' and '.join(f'{mark:g}' for mark in marks)} taken for unknown"
    return metres.astype(np.float32), line


def find_cut_range(metres: NDArray[np.floating]) -> float | None:
    """The distance at which depth (h, w) in metres is cut off: the largest, of whole half metres, and many times as
    common as any a little nearer. A wall at exactly that distance, seen straight on, is mistaken for the cut.
    """
    found, counts = count_values(metres)
    if len(found) <= MIN_VALUES:
        return None
    last, number = float(found[-1]), int(counts[-1])
    whole = last >= MIN_RANGE and abs(2 * last - round(2 * last)) < 1e-4
    nearby = int(counts[:-1][found[:-1] >= NEARBY * last].max(initial=1))
    many = number >= max(MIN_PIXELS, CUT_SHARE * metres.size, CUT_TIMES * nearby)
    return last if whole and many else None
