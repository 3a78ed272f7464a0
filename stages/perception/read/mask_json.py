"""Masks of COCO's JSON: polygons, run lengths in each form, and boxes."""

import base64
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.errors import explain
from roomkin.stages.geometry.masks import OUTLINE
from roomkin.stages.perception.read.mask_shapes import (
    WHOLE_BOX,
    Mask,
    MaskShape,
    ShapeError,
    check_count,
    check_size,
    fill_outline,
    list_corners,
    refuse_shape,
)

ROBOFLOW = re.compile(r"(_(png|jpe?g|webp|bmp|tiff?|heic))?\.rf\.[^.]+\.\w+$")  # what it puts behind a name
WITHOUT_RESIZE = "a version of the data set without Resize and augmentations among its steps"
AREAS_NOT = {"line": "is a line", "linestrip": "is a line", "point": "is a point", "points": "are points"}
CORNERS = {"polygon", "rotation", "oriented_rectangle", "quadrilateral"}  # all of their corners are written
TURNED = ("angle", "rotation", "direction")  # of a rectangle


def read_coco(path: Path, data: dict[str, Any], width: int, height: int, picture: str) -> list[MaskShape]:
    """All annotations of the picture of this size and name.

    Raises:
        InputError: it is broken, of another size, of other pictures, or has an annotation that cannot be read.
    """
    with explain_unreadable(path, "COCO file"):
        names = {category["id"]: str(category["name"]).strip() for category in data["categories"]}
        image = _find_image(path, data, picture)
        size = int(image.get("width") or width), int(image.get("height") or height)
        check_size(path, size, width, height, WITHOUT_RESIZE if ROBOFLOW.search(str(image.get("file_name"))) else "")
        shapes: list[MaskShape] = []
        for number, item in enumerate(data["annotations"], 1):
            if image and item.get("image_id") != image.get("id"):
                continue
            if item.get("category_id") not in names:
                what = f"annotation {number} is of category {item.get('category_id')!r}, which has no name."
                raise InputError(path, what, "name it in categories", code="E-MASKS-NAMES")
            label = names[item["category_id"]]
            check_count(path, len(shapes) + 1, width, height)
            try:
                mask, remark = _read_mask(item, (height, width))
            except ShapeError as error:
                raise refuse_shape(path, f"annotation {number}", label, error) from None
            shapes.append(MaskShape(label, mask, remark))
        return shapes


def _find_image(path: Path, data: dict[str, Any], picture: str) -> dict[str, Any]:
    """The file's entry of the picture; empty if it names no pictures."""
    images = data.get("images") or []
    names = [Path(str(one.get("file_name", "")).replace("\\", "/")).name for one in images]
    mine = [one for one, name in zip(images, names, strict=True) if name == picture]
    mine = mine or [one for one, name in zip(images, names, strict=True) if _was_called(name, picture)]
    pictures = {item.get("image_id") for item in data["annotations"]}
    if len(mine) > 1 or (not mine and len(images) > 1) or (not images and len(pictures) > 1):
        known = ", ".join(str(one.get("file_name")) for one in images[:5])
        what = f"has no picture called {picture}, but {known or 'several without names'}, ..."
        what = f"has {len(mine)} pictures called {picture}." if mine else what
        raise InputError(path, what, "rename the picture, or give a file of it alone", code="E-MASKS-PICTURE")
    if picture and images and not mine and images[0].get("file_name"):
        print(f"{path}: is of {images[0]['file_name']}, the picture is {picture}")
    return dict((mine or images or [{}])[0])


def _was_called(name: str, picture: str) -> bool:
    """Whether Roboflow gave a picture of this name another one, in which letters are replaced by - and _."""
    plain, wanted = (re.sub("[^a-z0-9]", "", one.lower()) for one in (ROBOFLOW.sub("", name), Path(picture).stem))
    return plain == wanted


def _read_mask(item: dict[str, Any], size: tuple[int, int]) -> tuple[Mask | None, str]:
    """Pixels (H, W) of an annotation, and a remark on it."""
    given = item.get("segmentation")
    box = np.asarray(item.get("bbox") or [], dtype=float).ravel()
    boxed = len(box) == 4 and bool(np.isfinite(box).all()) and box[2] > 0 and box[3] > 0
    if not given:
        if not boxed:
            return None, "has no outline"
        if (item.get("attributes") or {}).get("rotation"):
            raise ShapeError("is a box that is turned, without an outline")
        x, y, wide, high = box
        return fill_outline(list_corners(x, y, x + wide, y + high), size), WHOLE_BOX
    mask, remarks = _read_segmentation(given, size)
    if boxed and not _holds(box, mask):
        raise ShapeError(f"has its outline elsewhere than its bbox {box.tolist()}")
    if item.get("iscrowd"):
        remarks = [*remarks, "is marked as a crowd, and taken as one thing"]
    return mask, " and ".join(remarks)


def _holds(box: Any, mask: Mask) -> bool:
    """Whether a box of x, y, width, height (or x, y, right, bottom, as some write it) has most of a mask (H, W)."""
    rows, columns = np.nonzero(mask)
    left, top = box[0] - OUTLINE, box[1] - OUTLINE
    for right, bottom in ((box[0] + box[2], box[1] + box[3]), (box[2], box[3])):
        inside = (columns >= left) & (columns <= right + OUTLINE) & (rows >= top) & (rows <= bottom + OUTLINE)
        if inside.sum() >= len(rows) / 2:
            return True
    return False


def _read_segmentation(given: Any, size: tuple[int, int]) -> tuple[Mask, list[str]]:
    """Pixels (H, W) of run lengths, or of one or several polygons, each a list of numbers or of pairs."""
    if isinstance(given, dict):
        stated = given.get("size")
        if stated is not None and list(map(int, stated)) != list(size):
            raise ShapeError(f"has run lengths of {stated[1]}x{stated[0]} pixels")
        return _fill_runs(given["counts"], size), []
    if not isinstance(given, list):
        raise ShapeError("has a segmentation that is neither polygons nor run lengths")
    if isinstance(given[0], list) and given[0] and isinstance(given[0][0], bool):  # pixels, row by row
        if [len(given), *{len(row) for row in given}] != list(size):
            raise ShapeError(f"has a mask of {len(given[0])}x{len(given)} pixels")
        return np.array(given, dtype=bool), []
    mask, remarks = np.zeros(size, dtype=bool), []
    if not isinstance(given[0], (list, dict)) or all(_is_pair(part) for part in given):
        given = [given]
    for part in given:
        if isinstance(part, dict):
            mask |= _read_segmentation(part, size)[0]
        elif _are_runs(part, size):
            mask |= _fill_runs(part, size)
            remarks = ["has run lengths in the place of corners"]
        else:
            mask |= fill_outline(part, size)
    return mask, remarks


def _is_pair(part: Any) -> bool:
    return isinstance(part, list) and len(part) == 2 and not isinstance(part[0], (list, dict))


def _are_runs(part: list[Any], size: tuple[int, int]) -> bool:
    """Whether numbers are run lengths: whole, and as many pixels as the picture has."""
    whole = all(isinstance(one, (int, float)) and one >= 0 and one == int(one) for one in part)
    return whole and sum(part) == size[0] * size[1]


def _fill_runs(counts: Any, size: tuple[int, int]) -> Mask:
    """Pixels (H, W) of run lengths, column by column, starting outside; a string is compressed."""
    runs = _unpack_runs(counts) if isinstance(counts, str) else [int(count) for count in counts]
    if sum(runs) != size[0] * size[1] or min(runs, default=0) < 0:
        raise ShapeError(f"has run lengths of {sum(runs)} pixels, the picture has {size[0] * size[1]}")
    bits = np.repeat(np.arange(len(runs)) % 2, runs).astype(bool)
    return np.asarray(bits.reshape(size[::-1]).T)


def _unpack_runs(text: str) -> list[int]:
    """COCO's compressed run lengths: 5 bits a character, low bits first; from the fourth on, less the last but one."""
    runs: list[int] = []
    value, shift = 0, 0
    for letter in text:
        bits = ord(letter) - 48
        if not 0 <= bits < 64 or shift > 30:
            raise ShapeError(f"has run lengths with {letter!r}, which COCO does not write")
        value |= (bits & 31) << shift
        shift += 5
        if not bits & 32:
            value -= (1 << shift) if bits & 16 else 0
            runs.append(value + (runs[-2] if len(runs) > 2 else 0))
            value, shift = 0, 0
    return runs


def read_labelme(path: Path, data: dict[str, Any], width: int, height: int, picture: str) -> list[MaskShape]:
    """All shapes of a file for a picture of this size and name.

    Raises:
        InputError: it is broken, of another size, or has a shape that cannot be read.
    """
    with explain_unreadable(path, "labelme file"):
        check_size(path, (int(data.get("imageWidth") or width), int(data.get("imageHeight") or height)), width, height)
        named = Path(str(data.get("imagePath") or "").replace("\\", "/"))
        if picture and named.name and named.stem != Path(picture).stem:
            print(f"{path}: is of {named.name}, the picture is {picture}")
        shapes = []
        for number, shape in enumerate(data["shapes"], 1):
            label, group = str(shape.get("label") or "").strip(), shape.get("group_id")
            try:
                mask = _read_shape(shape, (height, width))
            except ShapeError as error:
                raise refuse_shape(path, f"shape {number}", label, error) from None
            found, remark = (None, mask) if isinstance(mask, str) else (mask, "")
            shapes.append(MaskShape(label, found, remark, group))
        return shapes


def _read_shape(shape: dict[str, Any], size: tuple[int, int]) -> Mask | str:
    """Pixels (H, W) of a shape, or in words why it has none."""
    kind, points = shape.get("shape_type") or "polygon", shape["points"]
    if kind in AREAS_NOT:
        return f"{AREAS_NOT[kind]}, no area"
    if kind == "mask":
        return _paste_mask(shape, points, size)
    if kind in CORNERS or (kind == "rectangle" and len(points) == 4):
        return fill_outline(points, size)
    if kind == "rectangle" and len(points) == 2:
        if any(shape.get(key) for key in TURNED):
            raise ShapeError("is a rectangle that is turned, but has two corners alone")
        return fill_outline(list_corners(*points[0], *points[1]), size)
    if kind == "circle" and len(points) == 2:
        center, edge = np.asarray(points, dtype=float)
        angles = np.linspace(0, 2 * np.pi, 64, endpoint=False)
        around = np.linalg.norm(edge - center) * np.stack([np.cos(angles), np.sin(angles)], 1)
        return fill_outline(center + around, size)
    raise ShapeError(f"is a {str(kind)!r} of {len(points)} points, which is not read")


def _paste_mask(shape: dict[str, Any], points: Any, size: tuple[int, int]) -> Mask | str:
    """A mask of its bounding box alone, as a PNG in base64, laid into the picture."""
    if not shape.get("mask"):
        return "is a mask without its pixels"
    left, top, right, bottom = np.rint(np.asarray(points, dtype=float).ravel()).astype(int).tolist()
    try:
        with Image.open(io.BytesIO(base64.b64decode(shape["mask"])), formats=("PNG",)) as image:
            if max(abs(right - left + 1 - image.width), abs(bottom - top + 1 - image.height)) > 1:
                raise ShapeError(f"is a mask of {image.width}x{image.height} pixels in a box of another size")
            if image.mode not in ("1", "L", "P", "I;16"):
                raise ShapeError(f"is a mask with {len(image.getbands())} channels")
            inside = np.asarray(image) > 0
    except ShapeError:
        raise
    except Exception as error:  # each decoder raises its own kinds for broken data
        raise ShapeError(f"is a mask that cannot be decoded ({explain(error)})") from None
    mask = np.zeros(size, dtype=bool)
    rows, columns = np.nonzero(inside)
    rows, columns = rows + top, columns + left
    seen = (rows >= 0) & (rows < size[0]) & (columns >= 0) & (columns < size[1])
    mask[rows[seen], columns[seen]] = True
    return mask
