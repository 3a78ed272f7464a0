"""One RGB-D frame as it was found, before it becomes an input folder."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError

LONGEST = 1600  # pixels of the longer side of a picture; larger ones are made smaller
STRETCHED = 0.02  # by which the proportions of two pictures of the same view may differ
MEND = "save the picture upright, without EXIF data, as the same view as depth and masks"
NOTHING = {"", "background", "ceiling", "unknown", "unlabeled", "unlabelled", "void"}


def is_nothing(label: str) -> bool:
    """Whether a label says that there is no object, e.g. `_background_`."""
    return label.strip().strip("_").lower() in NOTHING


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
        """That nothing tells whether something is turned as the picture is."""
        what = f"is turned by its EXIF data (orientation {self.orientation}), and nothing tells whether {of} is."
        return InputError(self.path, what, MEND, code="E-PICTURE-TURNED")


@dataclass(frozen=True)
class Labelled:
    """values (H, W) uint16, 0: nothing; what each value is called, e.g. {1: "mug", 2: "floor"}."""

    values: NDArray[np.uint16]
    labels: dict[int, str]


@dataclass(frozen=True)
class Frame:
    """rgb (H, W, 3) uint8; depth (h, w) float32 metres along the optical axis, 0: unknown, of the same view at any
    size; intrinsics (3, 3) in pixels of `rgb`; masks of the size of `rgb`, if there are any; what was found, in lines;
    OpenCV's coefficients of the lens, by which all of it is bent, if they are known; how its picture was turned.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    intrinsics: NDArray[np.float64]
    masks: Labelled | None = None
    notes: Sequence[str] = field(default=())
    distortion: NDArray[np.float64] | None = None
    turn: Turn | None = None
