"""Where a mask ends in the picture, and where its thing may go on unseen: without depth."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
STEPS = np.array([(-1, 0), (0, -1), (1, 0), (0, 1)])  # out of the mask, x and y
BAND = 0.05  # of a mask's extent: its pixels nearest to an end; chosen
BEYOND = 0.01  # of the picture's longer side, from an end to what is next to it: masks leave gaps; chosen
MOST = 0.5  # share of an end next to which something is, from which on it is so; chosen


@dataclass(frozen=True)
class Ends:
    """The ends of a mask to the left, top, right and bottom.

    Attributes:
        at: (4,) pixels, signed along `STEPS`: -x0, -y0, x1, y1.
        cut: (4,) whether the picture's border ends it.
        met: of each side, the thing that it ends at; 0: none.
        limit: (4,) where that thing ends, along the same direction.
    """

    at: Array
    cut: Mask
    met: tuple[int, int, int, int]
    limit: Array


def measure_ends(masks: NDArray[np.integer], value: int, inside: Mask) -> Ends:
    """The ends of one of the masks (H, W).

    Args:
        inside: (H, W) pixels that show something: no frame around the picture.
    """
    height, width = masks.shape
    rows, columns = np.nonzero(masks == value)
    pixels = np.column_stack([columns, rows])
    at, cut, met, limit = np.zeros(4), np.zeros(4, bool), [], np.zeros(4)
    for side, step in enumerate(STEPS):
        rim = find_rim(pixels, step)
        along = rim @ step
        at[side] = limit[side] = along.max() + 0.5
        last = rim[along >= along.max() - max(2.0, BAND * np.ptp(pixels @ step))]
        x, y = (last + max(5, round(BEYOND * max(masks.shape))) * step).T
        there = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = np.where(there, x, 0), np.where(there, y, 0)
        there &= inside[y, x]
        other = np.where(there & (masks[y, x] != value), masks[y, x], 0)
        cut[side] = (~there).mean() > MOST
        counts = np.bincount(other)
        counts[0] = 0
        found = int(counts.argmax()) if counts.max() > MOST * len(last) else 0
        met.append(found)
        if found:
            shown = np.column_stack(np.nonzero(masks == found)[::-1])
            limit[side] = max(at[side], float((shown @ step).max()) + 0.5)
    return Ends(at, cut, (met[0], met[1], met[2], met[3]), limit)


def find_rim(pixels: NDArray[np.integer], step: NDArray[np.integer]) -> NDArray[np.integer]:
    """Of the pixels (N, 2) the last along `step` in each row or column."""
    across = pixels @ np.abs(step[::-1])
    order = np.lexsort((pixels @ step, across))
    last = np.append(np.diff(across[order]) != 0, True)
    return pixels[order[last]]


def measure_all(masks: NDArray[np.integer], values: list[int], inside: Mask) -> Mapping[int, Ends]:
    """The ends of masks (H, W) by their values."""
    things = np.where(np.isin(masks, values), masks, 0)
    return {value: measure_ends(things, value, inside) for value in values}
