"""Read depth from PNG, TIFF, PGM, EXR, NPZ and NPY, and find out whether it is in metres or millimetres.

One array of a file of numpy's, whatever empty axes a simulator leaves around it.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from roomkin.stages.config.recordings import DEPTH_FILES, DEPTH_IMAGES
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import explain_unreadable, read_npz
from roomkin.stages.contracts.images import NEAREST, SKY, check_depth, read_masks
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.geometry.depth_forms import MIN_PIXELS, MIN_VALUES, count_values, find_marks, remove_marks
from roomkin.stages.perception.read.depth_scale import UNITS, Stated, find_scale

ARRAYS = (".npy", ".npz")
# Chosen; what they find on frames of cameras is in docs/results/your-data.md.
CUT_TIMES, CUT_SHARE = 20, 0.002  # times the pixels of any nearby value, and share of all, at the end of the range
NEARBY = 0.9  # share of the range from which on values are nearby
MIN_RANGE = 2.0  # metres: no camera's range is shorter
CONFIDENCE = "the confidence of this very depth, or delete it"


def read_array(path: Path, name: str) -> NDArray[Any]:
    """The array of an NPY file, or the one of this name or the only one of an NPZ file, without axes of length 1.

    Raises:
        InputError: several arrays, none of which is called so.
    """
    if path.suffix.lower() == ".npy":
        return np.squeeze(np.asarray(np.load(path, allow_pickle=False)))
    arrays = read_npz(path)
    if name not in arrays and len(arrays) != 1:
        what = f"holds {', '.join(arrays)}, and none of them is called {name}."
        fix = f"store one array (height, width) of numbers, called {name}"
        raise InputError(path, what, fix, code="E-ARRAY-MISSING")
    return np.squeeze(arrays.get(name, next(iter(arrays.values()))))


def read_raw(path: Path) -> NDArray[Any]:
    """The numbers (h, w) of a depth file, in its own unit.

    Raises:
        InputError: no depth: missing, of another format, in colors, or with 8 bits.
    """
    if path.suffix.lower() not in DEPTH_FILES:
        what = "is no kind of depth file that is known."
        raise InputError(path, what, f"one of {', '.join(DEPTH_FILES)}", code="E-DEPTH-FORMAT")
    with explain_unreadable(path, "depth file", "export it again"):
        if path.suffix.lower() in DEPTH_IMAGES:
            array = _read_image(path)
        else:
            array = read_array(path, "depth") if path.suffix.lower() != ".exr" else read_exr(path)
    array = np.squeeze(array)
    if array.ndim != 2 or 0 in array.shape or array.dtype.kind not in "fiu" or array.dtype.itemsize == 1:
        what = f"has shape {array.shape} and type {array.dtype}: it is no depth image."
        fix = "store one array (height, width) of numbers with 16 bits or more, called depth"
        raise InputError(path, what, fix, code="E-DEPTH-FORMAT")
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
        head = re.sub(rb"#[^\n]*", b"", path.read_bytes()[:1000])  # its fourth word: the largest number
        return np.rint(numbers * (int(head.split()[3]) / 65535)).astype(np.int32)  # Pillow scales them to 65535


def remove_unsure(raw: NDArray[Any], path: Path) -> tuple[NDArray[Any], str]:
    """Depth (h, w) that is unknown (0) where its camera is least sure, and a line with how much that is.

    Args:
        raw: as stored.
        path: how sure the camera is, 0 to 2, as phones with LiDAR write it: PNG or NPY.

    Raises:
        InputError: no such file, or one of another size.
    """
    with explain_unreadable(path, "file of confidence", CONFIDENCE):
        sure = read_array(path, "confidence") if path.suffix.lower() == ".npy" else read_masks(path)
    if sure.shape != raw.shape:
        what = f"has shape {sure.shape}, the depth {raw.shape}."
        raise InputError(path, what, CONFIDENCE, code="E-DEPTH-SIZE")
    return np.where(sure == 0, 0, raw), f"{100 * (sure == 0).mean():.0f} % of it left out, of low confidence"


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
        what = "no pixel has a depth above 0."
        raise InputError(path, what, "check how the camera saves depth", code="E-DEPTH-EMPTY")
    median = float(np.median(known))
    per_metre, how = find_scale(path, known, unit, stated, usual)
    if not NEAREST <= median / per_metre <= LARGEST:
        what = f"has the median {median:g}, which would be {median / per_metre:.3g} m: no room."
        fix = "another --unit: m, mm, or the number that stands for one metre"
        raise InputError(path, what, fix, code="E-DEPTH-UNIT")
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
    common as any a little nearer. A wall at exactly that distance, seen straight on, is mistaken for the cut."""
    found, counts = count_values(metres)
    if len(found) <= MIN_VALUES:
        return None
    last, number = float(found[-1]), int(counts[-1])
    whole = last >= MIN_RANGE and abs(2 * last - round(2 * last)) < 1e-4
    nearby = int(counts[:-1][found[:-1] >= NEARBY * last].max(initial=1))
    many = number >= max(MIN_PIXELS, CUT_SHARE * metres.size, CUT_TIMES * nearby)
    return last if whole and many else None


def read_exr(path: Path) -> NDArray[Any]:
    """The channel (h, w) of depth, which is printed if there are others.

    Raises:
        InputError: OpenEXR is not installed, or no channel, or more than one, is called as depth is.
    """
    try:
        import OpenEXR
    except ImportError:
        what = "is an EXR file, which nothing installed here reads."
        raise InputError(path, what, "pip install OpenEXR", code="E-LIBRARY-MISSING") from None
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels: dict[str, NDArray[Any]] = {}
        for number, part in enumerate(file.parts):
            data, shown = (np.asarray(part.header[name]).tolist() for name in ("dataWindow", "displayWindow"))
            if data != shown:  # a part of a picture, or one with a border: it would be stretched over the picture
                what = f"holds the pixels {data} of {shown} (dataWindow, displayWindow)."
                raise InputError(path, what, "save it without crop and overscan", code="E-DEPTH-SIZE")
            before = f"{part.name()}." if len(file.parts) > 1 and part.name() else ""
            channels |= {before + name: np.array(one.pixels) for name, one in file.channels(number).items()}
    name = depth_channel(path, channels)
    if len(channels) > 1:
        others = ", ".join(one for one in channels if one != name)
        print(f"{path}: depth is its channel {name}, not {others}")
    return channels[name]


def depth_channel(path: Path, channels: dict[str, NDArray[Any]]) -> str:
    """The name of the depth channel: one called Z or depth, or of a layer called so; else any, if all are the same.

    Raises:
        InputError: it may be one of several.
    """
    named = [name for name in channels if "depth" in re.split(r"\W+", name.lower()) or _is_z(name, channels)]
    first, *others = named or list(channels)
    if not all(np.array_equal(channels[first], channels[other], equal_nan=True) for other in others):
        what = f"has the channels {', '.join(named or channels)}: which of them is depth?"
        raise InputError(path, what, "save depth alone, or call its channel Z", code="E-DEPTH-FORMAT")
    return first


def _is_z(name: str, channels: dict[str, NDArray[Any]]) -> bool:
    """Whether a channel is called Z, and is none of a vector."""
    *layer, channel = name.split(".")
    return channel.lower() == "z" and ".".join([*layer, "X"]) not in channels
