"""Whether two pictures may be of the same view: upright alike, and of one shape."""

from pathlib import Path

from stages.contracts import InputError
from stages.contracts.images import orientation_of

STRETCHED = 0.02  # by which the proportions of two pictures of the same view may differ: rounded sizes; chosen


def is_stretched(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two sizes (width, height) have other proportions."""
    return abs(one[0] / one[1] / (other[0] / other[1]) - 1) > STRETCHED


def check_upright(path: Path) -> None:
    """Refuse a picture that its EXIF data turn.

    Raises:
        InputError: they do; nothing tells how depth, masks and camera lie on it.
    """
    if (orientation := orientation_of(path)) != 1:
        what = f"is turned by its EXIF data (orientation {orientation}), and nothing tells whether its depth is."
        mend = "save the picture upright, without EXIF data, as the same view as depth and masks"
        raise InputError(path, what, mend, code="E-PICTURE-TURNED")
