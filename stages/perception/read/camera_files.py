"""Read a file of intrinsics of any tool: numbers, or names with their values."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import explain_unreadable, read_npz
from roomkin.stages.contracts.files import decode_file
from roomkin.stages.geometry.frames import make_intrinsics

KNOWS = "a file with fx, fy, cx, cy or a 3x3 matrix (JSON, YAML, text, NPY), see docs/your-data.md"
# Keys under which files nest the color camera; a later one counts more.
DEEPER = ("calibration", "camera", "cam0", "intrinsic", "intrinsics", "rgbintrinsics", "colorintrinsics", "rgb",
          "color", "rgbcamera", "colorcamera")  # fmt: skip
MATRICES = ("intrinsics", "k", "cameramatrix", "intrinsicmatrix", "camk", "intrinsic", "cameraintrinsics",
            "cameraintrinsic", "colorintrinsics", "rgbintrinsics", "intrinsiccolor", "calibrationcolorintrinsic",
            "colorcameramatrix", "kcolor", "krgb", "mtx", "p", "projectionmatrix")  # fmt: skip
FOCAL = ("fx", "flx", "fxcolor", "fxrgb", "focallengthx")
ANGLE = ("cameraanglex", "fovx", "hfov")
COLMAP = {  # names of the parameters after width and height; no other model of COLMAP's is read
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
    "OPENCV": "fx fy cx cy k1 k2 p1 p2",
    "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6",
}
MAX_YAML = 1_000_000  # characters, which take half a minute; chosen
CORNER = 0.5  # pixels: where COLMAP and NeRF tools have the middle of the first pixel; here it is at 0


def contents(path: Path, picture: str = "") -> list[float] | dict[str, Any]:
    """Plain numbers; or names, in small letters and digits alone, with their values.

    Args:
        path: JSON, YAML, text (COLMAP's cameras.txt, too), NPY or NPZ.
        picture: the picture's file name, for files of many cameras.

    Raises:
        InputError: neither.
    """
    with explain_unreadable(path, "file of intrinsics", KNOWS):
        data = load(path)
        if isinstance(data, list) and data and all(isinstance(one, float) for one in data):
            return data
        chosen = _of_picture(path, data, picture)
        if isinstance(chosen, dict):
            if {"cam0", "cam1"} <= set(chosen):
                print(f"{path}: of its cameras cam0 is taken")
            return flatten_values(chosen)
    raise InputError(path, "holds no intrinsics.", KNOWS, code="E-CAMERA-INTRINSICS")


def load(path: Path) -> Any:
    """A list of floats if a file has nothing else; else its JSON, YAML, COLMAP lines or `name = value`, as data."""
    if path.suffix.lower() == ".npy":
        return np.load(path, allow_pickle=False).astype(float).ravel().tolist()
    if path.suffix.lower() == ".npz":
        return {name: array.tolist() for name, array in read_npz(path).items() if array.dtype.kind in "fiub"}
    text = decode_file(path)
    try:
        return [float(word) for word in re.split(r"[\s,;\[\]]+", text) if word]
    except ValueError:
        pass
    lines = [line for line in map(str.strip, text.splitlines()) if line and not line.startswith("#")]
    if lines and all(re.match(r"\d+ [A-Z_]+ \d+ \d+ ", line) for line in lines):
        return {"cameras": [_colmap(line) for line in lines]}
    if lines and all(re.match(r"[\w.]+\s*=", line) for line in lines):
        values = {name.strip(): value.strip() for name, _, value in (line.partition("=") for line in lines)}
        return values if len(values) == len(lines) else None
    if text.lstrip().startswith(("{", "[")):
        return json.loads(text)
    if ":" not in text:
        return None
    return parse_yaml(path, re.sub(r"^%YAML.*|!!opencv-matrix|^---$", "", text, flags=re.MULTILINE))


def parse_yaml(path: Path, text: str) -> Any:
    """The data in a user's YAML.

    Raises:
        InputError: it is large, or has aliases.
    """
    if len(text) > MAX_YAML:
        what = f"has {len(text):,} characters of YAML."
        raise InputError(path, what, "give what is needed alone", code="E-FILE-LARGE")
    if any(isinstance(token, yaml.AliasToken) for token in yaml.scan(text)):  # a few lines of them fill any memory
        raise InputError(path, "has YAML aliases (*name).", "write the values out", code="E-FILE-UNREADABLE")
    return yaml.safe_load(text)


def simplify_name(name: str) -> str:
    """A name in small letters and digits alone, without what is before a dot or C++ and settings put before."""
    return re.sub(r"[^a-z0-9]", "", name.lower().removeprefix("m_").removeprefix("param-").split(".")[-1])


def flatten_values(data: dict[str, Any]) -> dict[str, Any]:
    """Values by plain names; those nested under the color camera replace those above."""
    known = {simplify_name(str(key)): value for key, value in data.items()}
    for key in DEEPER:
        if isinstance(known.get(key), dict):
            inner = flatten_values(known[key])
            known = known | inner if has_camera(inner) else inner | known
    return known


def has_camera(known: dict[str, Any]) -> bool:
    """Whether plain names include a focal length or a matrix."""
    return any(name in known for name in (*FOCAL, *ANGLE, *MATRICES))


def find_first(known: dict[str, Any], *names: str) -> Any:
    """The value of the first of the names that has one."""
    return next((known[name] for name in names if known.get(name) is not None), None)


def _colmap(line: str) -> dict[str, Any]:
    """A camera of COLMAP's cameras.txt."""
    number, model, width, height, *numbers = line.split()
    about = {"camera_id": number, "width": int(width), "height": int(height), "distortion_model": model.lower()}
    names = COLMAP.get(model, "").split()
    if len(names) != len(numbers):
        return about | {"camera_model": "unread" if model not in COLMAP else "broken"}
    values = dict(zip(names, map(float, numbers), strict=True))
    if "f" in values:
        values["fx"] = values["fy"] = values.pop("f")
    values |= {"cx": values["cx"] - CORNER, "cy": values["cy"] - CORNER}
    return about | values


def _of_picture(path: Path, data: Any, picture: str) -> Any:
    """The entry of the camera that took a picture, by its name, or any if all are the same."""
    if not isinstance(data, (dict, list)):
        return data
    known = {simplify_name(str(key)): value for key, value in data.items()} if isinstance(data, dict) else {}
    above, several = dict[str, Any](), known.get("cameras", known.get("frames"))
    if isinstance(data, list):
        entries: list[tuple[Any, Any]] = list(enumerate(data))
    elif all(isinstance(one, dict) for one in data.values()) and all(str(key).isdecimal() for key in data):
        entries = list(data.items())  # BOP's scene_camera.json
    elif isinstance(several, (list, dict)) and not has_camera(flatten_values(data)):
        above = data
        entries = list(several.items() if isinstance(several, dict) else enumerate(several))
    else:
        return data
    entries = [(str(key), above | one) for key, one in entries if isinstance(one, dict)]
    mine = [one for key, one in entries if _is_of(key, one, Path(picture).stem)]
    cameras = {json.dumps(_camera_of(one), default=str) for _, one in entries}
    if len(mine) != 1 and len(cameras) > 1:
        what = f"has {len(cameras)} different cameras, and does not say which one took {picture or 'the picture'}."
        raise InputError(path, what, "give the one alone", code="E-CAMERA-PICTURE")
    return (mine or [one for _, one in entries] or [None])[0]


def _is_of(key: str, entry: dict[str, Any], stem: str) -> bool:
    """Whether an entry is a picture's: by its key (a number, a name), or by the file that it names."""
    named = str(find_first(entry, "file_path", "img_name", "file_name", "image_name", "name") or key).replace("\\", "/")
    is_number = stem.isdecimal() and key.isdecimal()
    return stem in (Path(named).stem, Path(named).name) or (is_number and int(stem) == int(key))


def _camera_of(entry: dict[str, Any]) -> dict[str, Any]:
    """The intrinsics in an entry, without the pose."""
    lens = {"w", "h", "width", "height", "fy", "fly", "cx", "cy", "ppx", "ppy", "k1", "coeffs"}
    names = lens.union(FOCAL, ANGLE, MATRICES)
    return {name: value for name, value in flatten_values(entry).items() if name in names}


def matrix_of(numbers: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[float, float] | None]:
    """K (3, 3) and the picture's size, if it is among the numbers.

    They are fx, fy, cx, cy; with width and height before or after them; or a matrix of 3x3, 3x4 or 4x4, row by row or
    column by column.

    Raises:
        ValueError: they are none of these, or have a skew.
    """
    if len(numbers) == 4:
        return make_intrinsics(*numbers), None
    if len(numbers) == 6:
        for size, (fx, fy, cx, cy) in ((numbers[:2], numbers[2:]), (numbers[4:], numbers[:4])):
            middle = np.array([cx, cy]) / np.maximum(size, 1e-9)
            if (size == np.rint(size)).all() and (np.abs(middle - 0.5) < 0.2).all():
                return make_intrinsics(fx, fy, cx, cy), (float(size[0]), float(size[1]))
        raise ValueError("six numbers that are no size with fx, fy, cx, cy")
    shapes = {9: (3, 3), 12: (3, 4), 16: (4, 4)}
    if len(numbers) not in shapes:
        raise ValueError(f"{len(numbers)} numbers are no matrix")
    rows, columns = shapes[len(numbers)]
    for found in (numbers.reshape(rows, columns), numbers.reshape(columns, rows).T):
        if np.array_equal(found[2, :3], [0, 0, 1]) and found[1, 0] == 0 and found[3:].tolist() in ([], [[0, 0, 0, 1]]):
            if abs(found[0, 1]) > 0.001 * abs(found[0, 0]):
                raise ValueError(f"a skew of {found[0, 1]:g}, which is not read")
            return make_intrinsics(found[0, 0], found[1, 1], found[0, 2], found[1, 2]), None
    raise ValueError("a matrix that is no [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
