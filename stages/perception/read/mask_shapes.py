"""What a mask file shows, shape by shape: each is counted, and used or named with the reason why not."""

from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import MAX_BYTES
from roomkin.stages.geometry.masks import polygon
from roomkin.stages.perception.read.frame import Labelled

Mask = NDArray[np.bool_]
NO_PIXELS = "has no pixels"
WHOLE_BOX = "has no outline, so that all of its box is taken"
FARTHEST_OUT = 2  # times the picture's longer side: no corner that somebody drew lies farther out; chosen


@dataclass(frozen=True)
class MaskShape:
    """One shape or annotation: its label; its pixels (H, W), if any; a remark on it. Shapes of one label and group are
    one object."""

    label: str
    mask: Mask | None = None
    remark: str = ""
    group: Hashable = None


class ShapeError(ValueError):
    """A shape that cannot be read, so that its object would be lost or misplaced; its text gives the reason."""


def lay_shapes(path: Path, shapes: Sequence[MaskShape], kind: str) -> Labelled:
    """All shapes in one label image; of two that overlap the smaller one lies on top. Prints how many are used.

    Args:
        path: of their file.
        shapes: in its order.
        kind: what it calls them, in the plural.

    Raises:
        InputError: no shape has a pixel.
    """
    objects: dict[Hashable, Mask] = {}
    members: dict[Hashable, list[MaskShape]] = {}
    remarks: list[tuple[str, str]] = []
    for number, shape in enumerate(shapes):
        empty = shape.mask is not None and not shape.mask.any()
        remarks += [(shape.label, NO_PIXELS if empty else shape.remark)] if empty or shape.remark else []
        if shape.mask is None or empty:
            continue
        key: Hashable = number if shape.group is None else (shape.label, shape.group)
        objects[key] = shape.mask | objects[key] if key in objects else shape.mask
        members.setdefault(key, []).append(shape)
    if not objects:
        what = f"shows no object in this picture: {list_remarks(remarks) or f'it has no {kind}'}."
        raise InputError(path, what, "masks of this very picture", code="E-MASKS-EMPTY")
    numbers = {key: number for number, key in enumerate(objects, 1)}
    values = np.zeros(next(iter(objects.values())).shape, dtype=np.uint16)
    for key in sorted(objects, key=lambda one: -int(objects[one].sum())):
        values[objects[key]] = numbers[key]
    shown = set(np.unique(values).tolist())
    used = {key: members[key] for key in objects if numbers[key] in shown}
    remarks += [(shape.label, "is covered by others") for key in objects if key not in used for shape in members[key]]
    count = sum(map(len, used.values()))
    grouped = f", as {len(used)} objects" if len(used) < count else ""
    unused = f": {list_remarks(remarks)}" if remarks else ""
    print(f"{path}: {len(shapes)} {kind}, {count} used{grouped}{unused}")
    return Labelled(values, {numbers[key]: some[0].label for key, some in used.items()})


def list_remarks(remarks: Iterable[tuple[str, str]]) -> str:
    """Labels with remarks, e.g. "'cup' has no pixels, 'line' (3) is a line, no area"."""
    counts = Counter(remarks)
    return ", ".join(f"{label!r}{f' ({n})' if n > 1 else ''} {what}" for (label, what), n in counts.items())


def fill_outline(points: Any, shape: tuple[int, int]) -> Mask:
    """Pixels (H, W) inside a polygon; its corners, in pixels, are pairs or x and y in turn.

    Raises:
        ShapeError: no numbers, not in pairs, in shares of the picture, or far outside of it: no corners.
    """
    try:
        corners = np.asarray(points, dtype=np.float64).ravel()
    except (ValueError, TypeError):
        raise ShapeError("has corners that are no numbers") from None
    if len(corners) % 2 or not np.isfinite(corners).all():
        raise ShapeError(f"has {len(corners)} numbers for its corners, which are no pairs of x and y")
    if len(corners) and np.abs(corners).max() > FARTHEST_OUT * max(shape):
        raise ShapeError(f"has a corner at {np.abs(corners).max():g}, far outside of the picture")
    if len(corners) >= 6 and 0 < corners.max() <= 1 and corners.min() >= 0:
        raise ShapeError("has corners in shares of the picture, not in pixels")
    return polygon(corners, shape)


def list_corners(left: float, top: float, right: float, bottom: float) -> NDArray[np.float64]:
    """The corners (4, 2) of a rectangle."""
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


def check_size(path: Path, found: tuple[int, int], width: int, height: int, fix: str = "") -> None:
    """Refuse masks of another size (width, height) than the picture's; `fix`: how masks of its size are had.

    Raises:
        InputError: they are.
    """
    if found != (width, height):
        what = f"is of {found[0]}x{found[1]} pixels, but the picture has {width}x{height}."
        raise InputError(path, what, fix or "masks of this very picture", code="E-MASKS-SIZE")


def check_count(path: Path, count: int, width: int, height: int) -> None:
    """Refuse so many masks of a picture as fill the memory.

    Raises:
        InputError: they do.
    """
    if count * width * height > MAX_BYTES:
        what = f"has {count} masks of this picture or more."
        raise InputError(path, what, "give those of its things alone", code="E-FILE-LARGE")


def refuse_shape(path: Path, which: str, label: str, why: object) -> InputError:
    """The refusal of a shape that cannot be read; `which`: its place in the file."""
    return InputError(path, f"{which}, {label!r}, {why}.", "draw it as a polygon, or remove it", code="E-MASKS-SHAPE")
