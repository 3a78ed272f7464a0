"""Read depth images: metres along the optical axis; millimetres are recognised, what is neither is refused."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.arrays import read_npz
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.images import FOLDER
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.geometry.depth_marks import find_marks, remove_marks
from roomkin.stages.geometry.gravity import is_upside_down
from roomkin.stages.geometry.inverse_depth import is_inverse, is_zbuffer

NEAREST = 0.1  # metres: the median depth of a picture of a room is between this and `LARGEST`
DEPTH_UNITS = (100, 256, 512, 1000, 4000, 5000, 6553.5, 10000)  # numbers that stand for a metre in data sets
SKY = 100.0  # metres: farther away is no room
FORMAT, UNIT = "E-DEPTH-FORMAT", "E-DEPTH-UNIT"
DOWN, TURNED = "E-PICTURE-UPSIDE-DOWN", "it is upside down, or a ceiling without a floor."
TURN = (
    "turn picture, depth and masks by 180 degrees; flip them top to bottom instead if writing is then mirrored "
    "(renderers store the bottom row first)"
)
UNSTRETCH = (
    "store near * far / (far - value * (far - near)), with near and far of the renderer's camera in metres; of depth "
    "that was stretched to 0..1 for show, what it was before"
)
WRITE = "np.savez(path, depth=...) with an array (height, width) in metres"


def read_depth(path: Path) -> tuple[NDArray[np.float32], bool]:
    """The array `depth` (H, W) in metres, 0: unknown, and the flag `exact`.

    Values that are negative, not finite, beyond 100 m, or marks (`depth_marks`) count as unknown. Whole numbers, and
    floats with a median beyond a metre when read as millimetres, are millimetres and are converted, which is printed.

    Raises:
        InputError: no such array, no depth at all, or neither metres nor millimetres.
    """
    if not path.is_file() and path.with_suffix(".png").is_file():
        raise InputError(path, "no such file, but there is a depth.png.", f"store its array: {WRITE}", code=FORMAT)
    arrays = read_npz(path, FOLDER)
    if "depth" not in arrays:
        raise InputError(path, "has no array named 'depth'.", WRITE, code=FORMAT)
    depth, exact = arrays["depth"], arrays.get("exact", np.array(False))
    if depth.dtype.kind not in "fiu":
        raise InputError(path, f"depth: has type {depth.dtype}.", WRITE, code=FORMAT)
    if depth.ndim != 2 or 0 in depth.shape:
        raise InputError(path, f"depth: has shape {depth.shape}.", WRITE, code=FORMAT)
    if exact.shape != () or exact.dtype.kind not in "biu":
        what = f"exact: has type {exact.dtype} and shape {exact.shape}."
        raise InputError(path, what, "one bool, or leave it out", code=FORMAT)
    if depth.dtype.itemsize == 1:
        raise InputError(path, "depth: has 8 bits: a picture of depth, not depth.", WRITE, code=FORMAT)
    # A wall that a person drew is one distance all over, so that of floats only what is beyond a room is a mark.
    marks = [] if exact else [mark for mark in find_marks(depth) if depth.dtype.kind in "iu" or mark > LARGEST]
    if marks:
        print(f"{path}: depth {' and '.join(f'{mark:g}' for mark in marks)} is taken for unknown")
        depth = remove_marks(depth, marks)
    known = np.where(np.isfinite(depth) & (depth > 0), depth, 0)
    if not known.any():
        raise InputError(path, "depth: no value is known (finite and above 0).", WRITE, code="E-DEPTH-EMPTY")
    factor = _metres_per_unit(path, known)
    if factor != 1:
        print(f"{path}: depth is in millimetres (median {np.median(known[known > 0]):g}), converted to metres")
    metres = (known * factor).astype(np.float32)
    check_depth(path, metres)
    return np.where(metres > SKY, np.float32(0), metres), bool(exact)


def check_depth(path: Path, values: NDArray[np.floating]) -> None:
    """Refuse inverse depth and z-buffers (H, W): as depth they give things of no size and place.

    Raises:
        InputError: it is.
    """
    if is_inverse(values):
        what = "looks like inverse depth: it grows towards the lower border, and floors and walls are flat in it."
        fix = "store depth in metres: 1 / values for disparity, by the scale of its network"
        raise InputError(path, what, fix, code=UNIT)
    if is_zbuffer(values):
        what = f"is a z-buffer, not metres: all within 0..1, half of it above {np.median(values[values > 0]):.3f}."
        raise InputError(path, what, UNSTRETCH, code="E-DEPTH-ZBUFFER")


def check_turned(where: object, points: NDArray[np.float64], known: NDArray[np.bool_], max_tilt: float) -> None:
    """Refuse a picture of points (H, W, 3), camera frame, that is upside down with its depth.

    Whether it was turned by 180 degrees or mirrored top to bottom is not in depth: a person sees it.

    Raises:
        InputError: nothing level faces up, and much faces down.
    """
    if is_upside_down(points, known, max_tilt):
        raise InputError(
            where, f"shows no level surface that faces up, but one that faces down: {TURNED}", TURN, code=DOWN
        )


def _metres_per_unit(path: Path, depth: NDArray[Any]) -> float:
    median = float(np.median(depth[depth > 0]))
    whole = depth.dtype.kind in "iu"
    if not whole and NEAREST <= median <= LARGEST:
        return 1.0
    if whole and depth.max() <= np.iinfo(np.uint8).max:
        what = f"depth: has no value above {depth.max():g}: bytes of a picture, not millimetres."
        raise InputError(path, what, WRITE, code=UNIT)
    if (100 if whole else 1000) <= median <= 1000 * LARGEST:
        return 0.001
    what = f"depth: has the median {median:.3g}, which is neither metres nor millimetres of a room."
    raise InputError(path, what, "write metres as float32, or millimetres as uint16", code=UNIT)
