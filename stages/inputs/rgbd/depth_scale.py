"""The scale of depth as the files beside it say it: which number stands for one metre."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from stages.contracts import InputError
from stages.contracts.depth import NEAREST
from stages.contracts.types import LARGEST
from stages.inputs.rgbd.camera_files import load, plain

PER_METRE, METRES, MILLIMETRES, MICROMETRES = "units to a metre", "metres a unit", "mm a unit", "micrometres a unit"
ANY = (PER_METRE, METRES, MILLIMETRES)
# What a number may mean under a name, in small letters and digits alone; a key inside `depth` has that before it.
NAMES = {
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
LEAST = 100.0  # units to a metre: what is called `scale` alone is at least that
LONGEST, MOST = 100_000, 50  # bytes of a file, and files of a folder, that are looked at


@dataclass(frozen=True)
class Stated:
    """What one file says: which file, the words, and what they may mean: the numbers that stand for one metre."""

    where: str
    words: str
    per_metre: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.words} in {self.where}"


def stated_beside(depth: Path, about: Path | None = None) -> list[Stated]:
    """What is said of the unit by the depth file itself, else by the file of intrinsics `about`, else beside them."""
    sources: list[list[Path]] = [[depth], [] if about is None else [about], _beside(depth.parent)]
    sources.append(_beside(depth.parent.parent))
    for files in sources:
        found = [one for file in files for one in _of_file(file)]
        if found:
            return list(dict.fromkeys(found))
    return []


def scale_of(path: Path, stated: Sequence[Stated], median: float) -> tuple[float, str]:
    """The number that stands for one metre, and who says so: the one by which depth of this median is of a room.

    Raises:
        InputError: there is none, or several.
    """
    said = ", ".join(map(str, stated[:3]))
    fitting: dict[str, tuple[float, Stated]] = {}
    for one in stated:
        for scale in one.per_metre:
            if NEAREST <= median / scale <= LARGEST:
                fitting.setdefault(f"{scale:.3g}", (scale, one))
    if len(fitting) == 1:
        return next((scale, str(one)) for scale, one in fitting.values())
    if not fitting:
        what = f"has the median {median:g}, which is no depth of a room by {said}."
        raise InputError(path, what, "correct it there, or say --unit", code="E-DEPTH-UNIT")
    could = " or ".join(f"{median / scale:.3g} m (--unit {scale:g})" for scale, _ in fitting.values())
    raise InputError(path, f"has the median {median:g}, by {said}: {could}.", "say which it is", code="E-DEPTH-UNIT")


def _beside(folder: Path) -> list[Path]:
    """Small files of a folder that may say something."""
    kinds = {".json", ".yaml", ".yml", ".txt", ".cfg"}
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in kinds) if folder.is_dir() else []
    return files[:MOST]


def _of_file(file: Path) -> list[Stated]:
    """What a file says; nothing if it cannot be read, for it may be of anything."""
    try:
        if file.suffix.lower() == ".npz":
            with np.load(file, allow_pickle=False) as arrays:
                small = [name for name in arrays.files if plain(name) in NAMES]
                data: Any = {name: arrays[name].item() for name in small if arrays[name].size == 1}
        elif file.suffix.lower() in (".png", ".tif", ".tiff"):
            with Image.open(file, formats=("PNG", "TIFF")) as image:
                data = {key: value for key, value in image.info.items() if isinstance(key, str)}
        elif file.is_file() and file.stat().st_size <= LONGEST:
            data = load(file)
        else:
            return []
    except Exception:  # of any kind of file, by any decoder
        return []
    return [Stated(file.name, words, scales) for words, scales in _said(data) if scales]


def _said(data: Any, parent: str = "", deep: int = 4) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Name with value, and the numbers that may stand for one metre by it."""
    if isinstance(data, list):
        data = dict(enumerate(data[:MOST]))
    if not isinstance(data, dict) or not deep:
        return
    keys = {plain(str(key)) for key in data}
    for key, value in data.items():
        name = plain(str(key))
        if isinstance(value, (dict, list)):
            yield from _said(value, name, deep - 1)
            continue
        inside = parent + name if parent in ("depth", "depthcamera") else name
        known = next((one for one in (inside.replace("camera", ""), name) if NAMES.get(one)), "")
        if known == "scale" and not keys & {"fx", "flx", "f"}:
            continue
        if known or (name in ("unit", "units") and inside != name):
            yield f"{key} {value}", _scales(value, NAMES.get(known, (METRES,)), known)


def _scales(value: Any, readings: tuple[str, ...], name: str) -> tuple[float, ...]:
    """What a value may mean, as numbers that stand for one metre."""
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
    return tuple(scale for scale in scales if name != "scale" or scale >= LEAST)
