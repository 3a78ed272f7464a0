"""The scale of depth, as an option or files state it, or as its median tells: which number stands for one metre."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.images import DEPTH_UNITS, NEAREST, UNSTRETCH
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.perception.read.camera_files import load, simplify_name

PER_METRE, METRES, MILLIMETRES, MICROMETRES = "units to a metre", "metres a unit", "mm a unit", "micrometres a unit"
ANY = (PER_METRE, METRES, MILLIMETRES)
# What a number may mean under a name, in small letters and digits alone; a key inside `depth` has that before it.
UNIT_NAMES = {
    "depthscale": ANY,  # Open3D: 1000; RealSense: 0.001; BOP: 0.1 mm
    "depthfactor": ANY,
    "depthscalefactor": ANY,
    "pngdepthscale": (PER_METRE,),  # of neural SLAM systems
    "depthmapfactor": (PER_METRE,),  # ORB-SLAM
    "depthshift": (PER_METRE,),  # ScanNet
    "integerdepthscale": (METRES,),  # instant-ngp
    "depthunitscalefactor": (METRES,),  # nerfstudio
    "depthunits": (METRES, MICROMETRES),  # RealSense, and its settings
    "depthunit": (METRES, MICROMETRES),
    "depthtometers": (METRES,),
    "scale": (PER_METRE, METRES),  # Replica; means much else, so that it must be beside a focal length
}
WORDS = {"m": 1.0, "meter": 1.0, "metre": 1.0, "dm": 10.0, "cm": 100.0, "centimeter": 100.0, "centimetre": 100.0,
         "mm": 1000.0, "millimeter": 1000.0, "millimetre": 1000.0, "um": 1e6, "micrometer": 1e6,
         "ft": 1 / 0.3048, "foot": 1 / 0.3048, "feet": 1 / 0.3048, "in": 1 / 0.0254, "inch": 1 / 0.0254,
         "inches": 1 / 0.0254}  # fmt: skip
MIN_SCALE = 100.0  # units to a metre: what is called `scale` alone is at least that; chosen
MAX_BYTES, MAX_FILES = 100_000, 50  # of a file, and of a folder, that are looked at; chosen
UNITS = {"m": 1.0, "mm": 1000.0}
# Metres: frames of depth cameras have less; more in millimetres is mostly another unit; chosen.
USUAL_NEAREST, USUAL_MEDIAN = 0.5, 6.0


@dataclass(frozen=True)
class Stated:
    """A unit as one file states it: the file, its words, and the numbers that may stand for one metre by them."""

    where: str
    words: str
    per_metre: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.words} in {self.where}"


def find_stated_units(depth: Path, about: Path | None = None) -> list[Stated]:
    """The units that the depth file itself states, else the file of intrinsics `about`, else files beside them."""
    sources: list[list[Path]] = [[depth], [] if about is None else [about], _list_beside(depth.parent)]
    sources.append(_list_beside(depth.parent.parent))
    for files in sources:
        found = [one for file in files for one in _read_file(file)]
        if found:
            return list(dict.fromkeys(found))
    return []


def find_scale(
    path: Path, known: NDArray[Any], unit: str, stated: Sequence[Stated], usual: float | None
) -> tuple[float, str]:
    """The number that stands for one metre of depth with the `known` numbers (N,), and its source in words.

    It is that of `unit` unless this is auto, else the one that files state, else the `usual` one, else the median's.

    Raises:
        InputError: there is none, or several.
    """
    median = float(np.median(known))
    if unit != "auto":
        per_metre, how = _read_unit(unit), "as stated"
        if stated and not any(np.isclose(per_metre, scale) for one in stated for scale in one.per_metre):
            how += f", though {stated[0]}"
        return per_metre, how
    if stated:
        return choose_stated_scale(path, stated, median)
    if usual is not None:
        return usual, "as such recordings have it"
    return _judge_by_median(path, known, median), "found by its median"


def choose_stated_scale(path: Path, stated: Sequence[Stated], median: float) -> tuple[float, str]:
    """The number that stands for one metre, and which file states it: the one that makes the median that of a room.

    Raises:
        InputError: there is none, or several.
    """
    stating = ", ".join(map(str, stated[:3]))
    fitting: dict[str, tuple[float, Stated]] = {}
    for one in stated:
        for scale in one.per_metre:
            if NEAREST <= median / scale <= LARGEST:
                fitting.setdefault(f"{scale:.3g}", (scale, one))
    if len(fitting) == 1:
        return next((scale, str(one)) for scale, one in fitting.values())
    if not fitting:
        what = f"has the median {median:g}, which is no depth of a room by {stating}."
        raise InputError(path, what, "correct it there, or say --unit", code="E-DEPTH-UNIT")
    could = " or ".join(f"{median / scale:.3g} m (--unit {scale:g})" for scale, _ in fitting.values())
    raise InputError(path, f"has the median {median:g}, by {stating}: {could}.", "say which it is", code="E-DEPTH-UNIT")


def _list_beside(folder: Path) -> list[Path]:
    """Files of a folder that may state a unit."""
    kinds = {".json", ".yaml", ".yml", ".txt", ".cfg"}
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in kinds) if folder.is_dir() else []
    return files[:MAX_FILES]


def _read_file(file: Path) -> list[Stated]:
    """The units that a file states; none if it cannot be read, for it may be of anything."""
    try:
        if file.suffix.lower() == ".npz":
            with np.load(file, allow_pickle=False) as arrays:
                small = [name for name in arrays.files if simplify_name(name) in UNIT_NAMES]
                data: Any = {name: arrays[name].item() for name in small if arrays[name].size == 1}
        elif file.suffix.lower() in (".png", ".tif", ".tiff"):
            with Image.open(file, formats=("PNG", "TIFF")) as image:
                data = {key: value for key, value in image.info.items() if isinstance(key, str)}
        elif file.is_file() and file.stat().st_size <= MAX_BYTES:
            data = load(file)
        else:
            return []
    except Exception:  # of any kind of file, by any decoder
        return []
    return [Stated(file.name, words, scales) for words, scales in _read_units(data) if scales]


def _read_units(data: Any, parent: str = "", deep: int = 4) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Names with values, and the numbers that may stand for one metre by them."""
    if isinstance(data, list):
        data = dict(enumerate(data[:MAX_FILES]))
    if not isinstance(data, dict) or not deep:
        return
    keys = {simplify_name(str(key)) for key in data}
    for key, value in data.items():
        name = simplify_name(str(key))
        if isinstance(value, (dict, list)):
            yield from _read_units(value, name, deep - 1)
            continue
        inside = parent + name if parent in ("depth", "depthcamera") else name
        known = next((one for one in (inside.replace("camera", ""), name) if UNIT_NAMES.get(one)), "")
        if known == "scale" and not keys & {"fx", "flx", "f"}:
            continue
        if known or (name in ("unit", "units") and inside != name):
            yield f"{key} {value}", _interpret(value, UNIT_NAMES.get(known, (METRES,)), known)


def _interpret(value: Any, readings: tuple[str, ...], name: str) -> tuple[float, ...]:
    """The numbers that may stand for one metre by a value."""
    word = str(value).strip().lower()
    if word.rstrip("s") in WORDS or word in WORDS:
        return (WORDS.get(word) or WORDS[word.rstrip("s")],)
    try:
        number = float(word)
    except ValueError:
        return ()
    if not np.isfinite(number) or number <= 0:
        return ()
    means = {PER_METRE: number, METRES: 1 / number, MILLIMETRES: 1000 / number, MICROMETRES: 1e6 / number}
    scales = dict.fromkeys(means[reading] for reading in readings)
    return tuple(scale for scale in scales if name != "scale" or scale >= MIN_SCALE)


def _judge_by_median(path: Path, known: NDArray[Any], median: float) -> float:
    whole = known.dtype.kind in "iu"
    if not whole and NEAREST <= median <= LARGEST:
        return UNITS["m"]
    fix = "say the unit with --unit: m, mm, or the number that stands for one metre"
    if LARGEST < known.max() <= np.iinfo(np.uint8).max:
        raise InputError(path, f"has no value above {known.max():g}: bytes, not millimetres.", fix, code="E-DEPTH-UNIT")
    if 1000 * NEAREST <= median <= 1000 * USUAL_MEDIAN:
        return UNITS["mm"]
    what = f"has the median {median:.3g}, which is neither metres nor millimetres of a room."
    if known.max() <= 1 or (whole and 1000 * LARGEST < median <= np.iinfo(np.uint16).max):
        scaled = " times 65535" if whole else ""
        what += f" A z-buffer{scaled}, also one from far to near, and stretched depth have such values."
        fix = UNSTRETCH
    if 1000 * USUAL_MEDIAN < median <= 1000 * LARGEST:
        units = [scale for scale in DEPTH_UNITS if scale > 1000 and median / scale >= USUAL_NEAREST]
        others = [f"{median / scale:.3g} m in 1/{scale:g} m" for scale in units]
        what = f"has the median {median:g}: {', '.join([f'{median / 1000:.3g} m in millimetres', *others])}."
        flags = ", ".join(f"--unit {unit}" for unit in ("mm", *map("{:g}".format, units)))
        fix = f"say which it is: {flags}, or the number that stands for one metre"
    raise InputError(path, what, fix, code="E-DEPTH-UNIT")


def _read_unit(unit: str) -> float:
    try:
        per_metre = UNITS.get(unit) or float(unit)
    except ValueError:
        per_metre = 0.0
    if not np.isfinite(per_metre) or per_metre <= 0:
        fix = "auto, m, mm, or the number that stands for one metre, e.g. 5000"
        raise InputError("--unit", f"is '{unit}'.", fix, code="E-DEPTH-UNIT")
    return per_metre
