"""Outlines that have numbers in the place of names: YOLO's lines, and the folder that segment-anything writes.

What the numbers of masks are called: a file of names, and which of the numbers have one.
"""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.files import decode_file
from roomkin.stages.contracts.images import read_masks
from roomkin.stages.perception.read.camera_files import parse_yaml
from roomkin.stages.perception.read.frame import Labelled
from roomkin.stages.perception.read.mask_shapes import (
    FARTHEST_OUT,
    WHOLE_BOX,
    Mask,
    MaskShape,
    ShapeError,
    check_count,
    check_size,
    fill_outline,
    lay_shapes,
    list_corners,
    refuse_shape,
)

NAMES_OPTION = '--labels with {"1": "mug", "2": "floor"}, or {"#ff0000": "mug"} for a picture in colors'
LISTED = 8  # numbers without a name that are told; chosen
# Where YOLO's data.yaml, Grounded-Segment-Anything and Label Studio's notes.json have their names.
INSIDE = ("names", "mask", "categories")
CLASSES = "--labels with data.yaml of the data set, or classes.txt with a name in each line"
OUTLINES = '--labels with {"0": "floor", "2": "mug"} by their numbers from 0; or leave out --masks, `see` finds names'
LINE = "a class and the corners as shares of the picture in each line, as YOLO writes them"


def read_names(path: Path) -> tuple[dict[int, str], bool]:
    """Names of values, and whether those are colors. `path`: JSON or YAML of names by value; a list of names, which
    counts from 0; a list of entries that have value and label, or id and name; or text with a name in each line.
    Raises InputError: none of these."""
    with explain_unreadable(path, "file of names", NAMES_OPTION):
        data = _load(path)
    if isinstance(data, dict):
        data = next((data[key] for key in INSIDE if isinstance(data.get(key), (list, dict))), data)
    if isinstance(data, list) and data and all(isinstance(one, dict) for one in data):
        data = {one.get("value", one.get("id")): one.get("label", one.get("name")) for one in data}
    elif isinstance(data, list):
        data = dict(enumerate(data))
    if not isinstance(data, dict) or not data:
        raise InputError(path, "holds no names.", NAMES_OPTION, code="E-MASKS-NAMES")
    if strange := [key for key in data if not re.fullmatch(r"\d{1,10}|#[0-9a-fA-F]{6}", str(key))]:
        raise InputError(path, f"names {strange[0]!r}, which is no value.", NAMES_OPTION, code="E-MASKS-NAMES")
    if not all(isinstance(name, str) and name.strip() for name in data.values()):
        raise InputError(path, "has values that are no names.", NAMES_OPTION, code="E-MASKS-NAMES")
    values = {str(key): name.strip(" .") or name for key, name in data.items()}
    names = {int(key[1:], 16) if key.startswith("#") else int(key): name for key, name in values.items()}
    return names, any(key.startswith("#") for key in values)


def _load(path: Path) -> Any:
    text = decode_file(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        return parse_yaml(path, text)
    if path.suffix.lower() in (".txt", ".names"):
        return [line for line in text.splitlines() if line.strip()]
    return json.loads(text)


def choose_named(
    path: Path, found: Mapping[int, str], labels: Path | None, names: Mapping[int, str], kind: str, fix: str
) -> list[int]:
    """Which of the numbers that masks have are named. The others are printed.

    Args:
        path: of the masks.
        found: the numbers, as they are told.
        labels: the file of names, if there is one.
        names: what it holds.
        kind: what the numbers are, in the plural.
        fix: how to give names.

    Raises:
        InputError: none is named.
    """
    if labels is None:
        raise InputError(path, f"has {len(found)} {kind} without names.", fix, code="E-MASKS-NAMES")
    known = [number for number in found if number in names]
    nameless = [told for number, told in found.items() if number not in names]
    if not known:
        what = f"names none of the {kind} of {path}: {', '.join(nameless[:5]) or 'nothing'}."
        raise InputError(labels, what, fix, code="E-MASKS-NAMES")
    if nameless:
        more = f" and {len(nameless) - LISTED} more" if len(nameless) > LISTED else ""
        print(f"{path}: without a name, left out: {', '.join(nameless[:LISTED])}{more}")
    return known


def read_yolo(path: Path, labels: Path | None, width: int, height: int) -> Labelled:
    """Masks of a text file: in each line a class and the corners of a polygon, or the middle and size of a box.

    Raises:
        InputError: no such lines, classes without names, or a shape that cannot be read.
    """
    with explain_unreadable(path, "text file of YOLO", LINE):
        lines = {number: line.split() for number, line in enumerate(decode_file(path).splitlines(), 1)}
    rows = {number: _read_line(path, number, words) for number, words in lines.items() if words}
    if rows and all(len(row) % 2 == 0 for row in rows.values()):  # of a network, which says last how sure it is
        rows = {number: row[:-1] for number, row in rows.items()}
    names = {} if labels is None else read_names(labels)[0]
    if not rows:
        return lay_shapes(path, [], "lines")
    found = {int(row[0]): f"class {row[0]:g}" for row in rows.values()}
    known = choose_named(path, found, labels, names, "classes", CLASSES)
    rows = {number: row for number, row in rows.items() if row[0] in known}
    check_count(path, len(rows), width, height)
    shapes = []
    for number, (kind, *shares) in rows.items():
        try:
            shapes.append(MaskShape(names[int(kind)], *_fill_shares(shares, width, height)))
        except ShapeError as error:
            raise refuse_shape(path, f"line {number}", names[int(kind)], error) from None
    return lay_shapes(path, shapes, "lines")


def _read_line(path: Path, number: int, words: list[str]) -> list[float]:
    try:
        row = [float(word) for word in words]
    except ValueError:
        row = []
    if len(row) < 5 or not np.isfinite(row).all() or row[0] < 0 or row[0] != int(row[0]):
        what = f"is no line of YOLO's: {' '.join(words)[:40]!r}."
        raise InputError(f"{path}:{number}", what, LINE, code="E-MASKS-FORMAT")
    return row


def _fill_shares(shares: list[float], width: int, height: int) -> tuple[Mask, str]:
    """Pixels (H, W) inside corners, or inside a box of middle and size, all in shares; and a remark."""
    if len(shares) % 2:
        raise ShapeError(f"has {len(shares)} numbers for its corners, which are no pairs of x and y")
    if np.abs(shares).max() > FARTHEST_OUT:
        raise ShapeError(f"has a corner at {np.abs(shares).max():g}, which is no share of the picture")
    corners, remark = np.reshape(shares, (-1, 2)), ""
    if len(corners) == 2:
        middle, half = corners[0], corners[1] / 2
        corners, remark = list_corners(*(middle - half), *(middle + half)), WHOLE_BOX
    return fill_outline(corners * (width, height), (height, width)), remark


def read_folder(path: Path, labels: Path | None, width: int, height: int) -> Labelled:
    """Masks of a folder: a picture for each outline, called by its number (0.png).

    Raises:
        InputError: no such pictures, ones of another size, or outlines without names.
    """
    files = sorted(file for file in path.iterdir() if file.suffix.lower() == ".png")
    numbered = {int(digits[-1]): file for file in files if (digits := re.findall(r"\d+", file.stem))}
    if len(numbered) < len(files) or not files:
        what = f"has {len(files)} pictures, {len(numbered)} of which have a number of their own."
        raise InputError(path, what, "a mask of each thing, called 0.png, 1.png, ...", code="E-MASKS-FORMAT")
    names = {} if labels is None else read_names(labels)[0]
    found = {number: numbered[number].name for number in sorted(numbered)}
    known = choose_named(path, found, labels, names, "outlines", OUTLINES)
    check_count(path, len(known), width, height)
    shapes = [MaskShape(names[number], _read_one(numbered[number], width, height)) for number in known]
    return lay_shapes(path, shapes, "outlines")


def _read_one(path: Path, width: int, height: int) -> Mask:
    """Pixels (H, W) of a picture that is a mask of one thing."""
    values = read_masks(path)
    check_size(path, (values.shape[1], values.shape[0]), width, height)
    if (count := len(np.unique(values))) > 2:
        what = f"has {count} different values: no mask of one thing."
        raise InputError(path, what, "0 outside and 255 inside", code="E-MASKS-FORMAT")
    return values > 0
