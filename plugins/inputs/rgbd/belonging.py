"""Whether depth belongs to its picture: at the outlines of things depth changes by steps.

Of a few frames, real and ray-cast, steps lie on 50 to 96 % of the outline in the median of the things where depth is
right, on 14 to 32 % where it is moved, of another lens or turned; on 54 % where the turned scene is nearly the same. Of
43 path-traced frames with drawn masks none is doubted as it is, 42 are when mirrored, 43 when moved by 40 pixels.
"""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d, distance_transform_edt

from stages.contracts import InputError

WIDTH = 640  # pixels at most of what is compared; larger frames are made smaller
NEAR = 3  # pixels from an outline in which a step belongs to it
STEP = 0.03  # share of the distance
MIN_OUTLINE = 20  # pixels: what has less of an outline says nothing
FEW, MANY = 0.33, 0.5  # shares of an outline: below, depth is doubted; from there on another place fits
MORE = 1.5  # times as much as where it lies
FARTHEST = 0.15  # share of the width by which depth may be moved
FLIPS = {"left to right": (1,), "upside down": (0,), "by 180 degrees": (0, 1)}

Mask = NDArray[np.bool_]
Outlines = list[tuple[NDArray[np.intp], NDArray[np.intp]]]  # rows and columns of each


def doubt_depth(depth: NDArray[np.float32], masks: NDArray[np.uint16], things: Sequence[int]) -> str:
    """What makes it doubtful that depth (H, W) lies on the things with these values of masks (H, W); "" if nothing.

    Raises:
        InputError: it fits when it is mirrored.
    """
    if (shrunk := depth.shape[1] / WIDTH) > 1:
        size = WIDTH, round(depth.shape[0] / shrunk)
        depth, masks = (cv2.resize(one, size, interpolation=cv2.INTER_NEAREST) for one in (depth, masks))  # type: ignore[assignment]
    if not (depth > 0).any():
        return ""
    near = cv2.dilate(find_steps(depth).astype(np.uint8), np.ones((2 * NEAR + 1,) * 2)) > 0
    outlines = [outline for value in things if len((outline := _outline(masks == value, near))[0]) >= MIN_OUTLINE]
    if not outlines:
        return ""
    share = _share(near, outlines)
    better = max(MANY, MORE * share)
    for how, axes in FLIPS.items():
        if (flipped := _share(np.flip(near, axes), outlines)) >= better:
            rates = f"its steps lie on {100 * share:.0f} % of the outlines, turned back on {100 * flipped:.0f} %"
            what = f"is turned {how} against the picture: {rates}."
            raise InputError(
                "depth",
                what,
                f"turn depth {how}, or picture and masks, as the camera saw them",
                code="E-DEPTH-MIRRORED",
            )
    there = f"depth in doubt: its steps lie on {100 * share:.0f} % of the outlines"
    moved, (right, down) = max(
        (_share(_move(near, right, down), outlines), (right, down)) for right, down in _moves(near)
    )
    if moved >= better:
        where = (
            f"{100 * right / near.shape[1]:+.0f} % of the width and {100 * down / near.shape[0]:+.0f} % of the height"
        )
        return f"{there}, moved by {where} on {100 * moved:.0f} %: it is not aligned to the picture"
    return f"{there}: it is not aligned to the picture, or of another one" if share < FEW else ""


def find_steps(depth: NDArray[np.float32]) -> Mask:
    """Where depth (H, W), 0: unknown, changes by a step; gaps are filled with what is nearest to them."""
    rows, columns = distance_transform_edt(depth <= 0, return_distances=False, return_indices=True)
    inverse = 1 / np.maximum(cv2.medianBlur(depth[rows, columns], 5), 1e-6)
    bend = [1, 0, 0, -2, 0, 0, 1]  # 0 on planes
    return np.asarray(np.max([np.abs(correlate1d(inverse, bend, axis)) for axis in (0, 1)], axis=0) > STEP * inverse)


def _outline(mask: Mask, near: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The outline of a thing, without the picture's border; none of one in and around which depth is flat."""
    around = cv2.dilate(mask.astype(np.uint8), np.ones((3, 3))) > 0
    inner = cv2.erode(mask.astype(np.uint8), np.ones((3, 3)), borderValue=1) > 0
    rows, columns = np.nonzero(mask & ~inner & near[around].any())
    return rows, columns


def _share(near: Mask, outlines: Outlines) -> float:
    return float(np.median([near[outline].mean() for outline in outlines]))


def _move(near: Mask, right: int, down: int) -> Mask:
    return np.roll(near, (down, right), (0, 1))


def _moves(near: Mask) -> Iterator[tuple[int, int]]:
    """Pixels to the right and down, so far apart that no place between them is missed."""
    farthest = round(FARTHEST * near.shape[1])
    for right in range(-farthest, farthest + 1, 2 * NEAR):
        for down in range(-farthest, farthest + 1, 2 * NEAR):
            yield right, down
