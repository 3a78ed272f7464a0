"""Masks of labelme and of tools that write its JSON (X-AnyLabeling)."""

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from plugins.inputs.rgbd.mask_shapes import (
    Mask,
    Shape,
    ShapeError,
    check_size,
    fill_outline,
    list_corners,
    refuse_shape,
)
from stages.contracts.arrays import explain_unreadable

AREAS_NOT = {"line": "is a line", "linestrip": "is a line", "point": "is a point", "points": "are points"}
CORNERS = {"polygon", "rotation", "oriented_rectangle", "quadrilateral"}  # all of their corners are written
TURNED = ("angle", "rotation", "direction")  # of a rectangle


def read_labelme(path: Path, data: dict[str, Any], width: int, height: int, picture: str) -> list[Shape]:
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
            shapes.append(Shape(label, None, mask) if isinstance(mask, str) else Shape(label, mask, group=group))
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
        return fill_outline(
            center + np.linalg.norm(edge - center) * np.stack([np.cos(angles), np.sin(angles)], 1), size
        )
    raise ShapeError(f"is a {str(kind)!r} of {len(points)} points, which is not read")


def _paste_mask(shape: dict[str, Any], points: Any, size: tuple[int, int]) -> Mask | str:
    """A mask of its bounding box alone, as a PNG in base64, laid into the picture."""
    if not shape.get("mask"):
        return "is a mask without its pixels"
    left, top, right, bottom = np.rint(np.asarray(points, dtype=float).ravel()).astype(int).tolist()
    try:
        with Image.open(io.BytesIO(base64.b64decode(shape["mask"])), formats=("PNG",)) as image:
            if max(abs(right - left + 1 - image.width), abs(bottom - top + 1 - image.height)) > 1:
                what = f"is a mask of {image.width}x{image.height} pixels in a box of another size"
                raise ShapeError(what)
            if image.mode not in ("1", "L", "P", "I;16"):
                raise ShapeError(f"is a mask with {len(image.getbands())} channels")
            inside = np.asarray(image) > 0
    except ShapeError:
        raise
    except Exception as error:  # each decoder raises its own kinds for broken data
        raise ShapeError(f"is a mask that cannot be decoded ({error.__class__.__name__})") from None
    mask = np.zeros(size, dtype=bool)
    rows, columns = np.nonzero(inside)
    rows, columns = rows + top, columns + left
    seen = (rows >= 0) & (rows < size[0]) & (columns >= 0) & (columns < size[1])
    mask[rows[seen], columns[seen]] = True
    return mask
