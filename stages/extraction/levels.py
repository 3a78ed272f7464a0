"""The levels on which an object carries others: the heights of most of its upper surface."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from roomkin.stages.contracts.category import Category
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.estimate import BIN, PROMINENT
from roomkin.stages.geometry.frames import Array, yaw_matrix
from roomkin.stages.geometry.room_planes import STRAY

LEVEL_BLUR = 0.003  # share of the distance: noise of heights, seen from little above; chosen
PLAN_CELLS = 16  # of a ground plan along either side; chosen
HIGHEST_POINTS = 3  # of a cell, the last of which is its height, as single ones are noise; chosen


def find_level(points: Array, box: UprightBox, distance: float) -> float | None:
    """The height of most of an object's upper surface, or where most of its front ends.

    Clutter, a backrest or a tap reach higher, but have fewer points. Candidates are heights with at least half as
    many points as the fullest one; the lowest carries the others and is taken. None: only a front is seen, or the
    level belongs to what the object stands on.

    Args:
        points: (N, 3) of the object, `distance` metres from the camera; their box.
    """
    heights = points[:, 2]
    low, high = float(heights.min()), float(heights.max())
    bins = int((high - low) / BIN)
    if bins < 3:
        return None
    blur = max(2.0, LEVEL_BLUR * distance / BIN)
    thick = 2 * blur * BIN
    upper = heights[is_uppermost(points, box, thick)]
    everywhere, above = (
        gaussian_filter1d(np.histogram(values, bins, (low, high))[0].astype(float), blur, mode="constant")
        for values in (heights, upper)
    )
    is_level = everywhere > PROMINENT * len(heights) / bins
    peaks = is_level & (above >= np.roll(above, 1)) & (above >= np.roll(above, -1))
    peaks &= above >= above.max() / 2
    peak = int(np.argmax(peaks if peaks.any() else above))
    height = low + (peak + 0.5) * (high - low) / bins
    higher = float((heights > height + thick).mean())
    is_front = not is_level[peak] and higher < STRAY
    is_base = height < np.quantile(heights, STRAY) + thick and higher > 0.5
    return None if is_front or is_base else height


def is_uppermost(points: Array, box: UprightBox, thick: float) -> NDArray[np.bool_]:
    """Which points (N, 3) are at most `thick` metres below the highest one over their cell of the ground plan."""
    inside = (points - box.center) @ yaw_matrix(box.yaw)[:, :2] / np.maximum(box.size[:2], 1e-6) + 0.5
    row, column = np.clip((inside * PLAN_CELLS).astype(int), 0, PLAN_CELLS - 1).T
    _, cells, counts = np.unique(row * PLAN_CELLS + column, return_inverse=True, return_counts=True)
    heights = points[np.lexsort((points[:, 2], cells)), 2]
    ends = heights[np.cumsum(counts) - np.minimum(counts, HIGHEST_POINTS)]
    return np.asarray(points[:, 2] > ends[cells] - thick)


def find_carrying_heights(category: Category | None, level: float | None, top: float) -> tuple[float, ...]:
    """Heights at which an object may carry others, the likeliest first; its box ends at `top`.

    A chair carries at its seat, a desk between its clutter and on top of that, a shelf at its top alone.
    """
    has_boards = category is not None and category.carries == "boards"
    return (top,) if level is None or has_boards else (level, top)
