"""A picture that its EXIF data turn: its depth and masks are turned with it, or it is refused."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError
from stages.contracts.images import orientation_of

STRETCHED = 0.02  # by which the proportions of two pictures of the same view may differ: rounded sizes; chosen


def is_stretched(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two sizes (width, height) have other proportions."""
    return abs(one[0] / one[1] / (other[0] / other[1]) - 1) > STRETCHED


@dataclass(frozen=True)
class Turn:
    """How EXIF data turned a picture that now is upright: its file, their orientation (1: not at all), its size."""

    path: Path
    orientation: int
    width: int
    height: int

    @property
    def stored(self) -> tuple[int, int]:
        """Width and height as the sensor wrote it."""
        return (self.height, self.width) if self.orientation > 4 else (self.width, self.height)

    def refusal(self, of: object) -> InputError:
        """The refusal of a picture of which it is unknown whether `of` is turned with it."""
        what = f"is turned by its EXIF data (orientation {self.orientation}), and nothing tells whether {of} is."
        mend = "save the picture upright, without EXIF data, as the same view as depth and masks"
        return InputError(self.path, what, mend, code="E-PICTURE-TURNED")


def find_turn(path: Path, rgb: NDArray[np.uint8]) -> Turn:
    """How a picture (H, W, 3), read upright, was turned.

    Raises:
        InputError: by half a turn or as in a mirror, or by a quarter of a square: depth of both ways has one size.
    """
    turn = Turn(path, orientation_of(path), rgb.shape[1], rgb.shape[0])
    if turn.orientation > 1 and not is_stretched(turn.stored, (turn.width, turn.height)):
        raise turn.refusal("its depth")
    return turn


def turn_array(array: NDArray[Any], orientation: int) -> NDArray[Any]:
    """An array (H, W, ...) as a viewer shows a picture of this orientation, 5 to 8: those of a quarter turn."""
    sideways = array.swapaxes(0, 1)
    return np.ascontiguousarray(sideways[:: -1 if orientation in (7, 8) else 1, :: -1 if orientation in (6, 7) else 1])


def turn_depth(turn: Turn, depth: NDArray[Any], path: Path) -> NDArray[Any]:
    """Depth (h, w) of any size as the upright picture has it; `path` is printed if it was turned for that."""
    if turn.orientation == 1 or is_stretched(depth.shape[::-1], turn.stored):
        return depth
    print(f"{path}: turned with its picture, whose EXIF data say so")
    return turn_array(depth, turn.orientation)
