"""A picture that its EXIF data turn: its depth, masks and intrinsics are turned with it, or it is refused."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError
from stages.contracts.images import orientation_of
from stages.inputs.rgbd.cameras import Matrix, matrix
from stages.inputs.rgbd.frame import Labelled, Turn, is_stretched


def turn_of(path: Path, rgb: NDArray[np.uint8]) -> Turn:
    """How a picture (H, W, 3), read upright, was turned.

    Raises:
        InputError: by half a turn or as in a mirror, or by a quarter of a square: depth of both ways has one size.
    """
    turn = Turn(path, orientation_of(path), rgb.shape[1], rgb.shape[0])
    if turn.orientation > 1 and not is_stretched(turn.stored, (turn.width, turn.height)):
        raise turn.refusal("its depth")
    return turn


def turned(array: NDArray[Any], orientation: int) -> NDArray[Any]:
    """An array (H, W, ...) as a viewer shows a picture of this orientation, 5 to 8: those of a quarter turn."""
    sideways = array.swapaxes(0, 1)
    return np.ascontiguousarray(sideways[:: -1 if orientation in (7, 8) else 1, :: -1 if orientation in (6, 7) else 1])


def upright_depth(turn: Turn, depth: NDArray[Any], of: Path) -> NDArray[Any]:
    """Depth (h, w) of any size as the upright picture has it, which is printed if it was turned for that."""
    if turn.orientation == 1 or is_stretched(depth.shape[::-1], turn.stored):
        return depth
    print(f"{of}: turned with its picture, whose EXIF data say so")
    return turned(depth, turn.orientation)


def upright_masks(turn: Turn, read: Callable[[int, int], Labelled], of: Path) -> Labelled:
    """Masks of the size that the upright picture has, or, turned, of the one that the sensor wrote."""
    try:
        return read(turn.width, turn.height)
    except InputError as error:
        if turn.orientation == 1 or error.code != "E-MASKS-SIZE":
            raise
    masks = read(*turn.stored)
    print(f"{of}: turned with its picture, whose EXIF data say so")
    return Labelled(turned(masks.values, turn.orientation), masks.labels)


def upright_camera(turn: Turn, read: Callable[[int, int], Matrix]) -> tuple[Matrix, bool]:
    """K of the upright picture, and whether that of the sensor's picture was turned for it.

    Where a file tells no size, it is of the picture in whose middle its axis is.

    Raises:
        InputError: it is of neither.
    """
    if turn.orientation == 1:
        return read(turn.width, turn.height), False
    sizes = {False: (turn.width, turn.height), True: turn.stored}
    found: dict[bool, Matrix] = {}
    errors: list[InputError] = []
    for is_stored, size in sizes.items():
        try:
            found[is_stored] = read(*size)
        except InputError as error:
            errors.append(error)
    if not found:
        raise errors[0]
    is_stored = min(found, key=lambda one: float(np.abs((2 * found[one][:2, 2] + 1) / sizes[one] - 1).sum()))
    if not is_stored:
        return found[False], False
    (fx, _, cx), (_, fy, cy), _ = found[True]
    x = turn.width - 1 - cy if turn.orientation in (6, 7) else cy
    y = turn.height - 1 - cx if turn.orientation in (7, 8) else cx
    print(f"intrinsics are of the {turn.height}x{turn.width} pixels that the sensor wrote, and turned with its picture")
    return matrix(fy, fx, x, y), True
