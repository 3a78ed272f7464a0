"""Outlines that have numbers in the place of names: YOLO's lines, and the folder that segment-anything writes."""

import re
from pathlib import Path

import numpy as np

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.files import decode_file
from roomkin.stages.contracts.images import read_masks
from roomkin.stages.perception.read.frame import Labelled
from roomkin.stages.perception.read.mask_names import choose_named, read_names
from roomkin.stages.perception.read.mask_shapes import (
    FARTHEST_OUT,
    WHOLE_BOX,
    Mask,
    Shape,
    ShapeError,
    check_count,
    check_size,
    fill_outline,
    lay_shapes,
    list_corners,
    refuse_shape,
)

CLASSES = "--labels with data.yaml of the data set, or classes.txt with a name in each line"
OUTLINES = '--labels with {"0": "floor", "2": "mug"} by their numbers from 0; or leave out --masks, `see` finds names'
LINE = "a class and the corners as shares of the picture in each line, as YOLO writes them"


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
            shapes.append(Shape(names[int(kind)], *_fill_shares(shares, width, height)))
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
    return lay_shapes(
        path, [Shape(names[number], _read_one(numbered[number], width, height)) for number in known], "outlines"
    )


def _read_one(path: Path, width: int, height: int) -> Mask:
    """Pixels (H, W) of a picture that is a mask of one thing."""
    values = read_masks(path)
    check_size(path, (values.shape[1], values.shape[0]), width, height)
    if (count := len(np.unique(values))) > 2:
        what = f"has {count} different values: no mask of one thing."
        raise InputError(path, what, "0 outside and 255 inside", code="E-MASKS-FORMAT")
    return values > 0
