"""The level on which things stand on an object: what most of its upper surface says, whatever else stands there."""

import re

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from stages.extraction.clouds import with_top
from stages.geometry.boxes import UprightBox
from stages.geometry.estimate import BIN, PROMINENT
from stages.geometry.frames import yaw_matrix

LEVEL_BLUR = 0.003  # share of the distance: noise of heights, seen from little above
CELLS = 16  # of a ground plan along either side
NEARLY = 0.5  # of the most that lies at one height
HIGHEST = 3  # of the points over a cell that counts: noise is higher
STRAY = 0.02  # share of an object's points that say nothing
# Last words of what is closed and ends in a level top, so that what is higher stands on it: no seat, shelf or bowl.
TOPPED = """
table desk counter countertop worktop workbench workstation island bar nightstand sideboard credenza buffet console
cabinet cupboard drawer dresser commode bureau chest stand unit wardrobe closet armoire trunk vanity
dishwasher oven stove cooker microwave fridge refrigerator freezer washer dryer machine
"""
OPEN = "shelf shelve shelving bookshelf bookshelve bookcase rack"  # boards one above the other
SEAT = "chair armchair stool sofa couch settee loveseat bench bed ottoman seat"  # stand on the floor


def level_of(points: NDArray[np.float64], box: UprightBox, distance: float) -> float | None:
    """The height at which most of an object's upper surface lies, or most of its front ends, of its points (N, 3).

    Clutter, a back or a tap are higher, but less of it; of heights at which nearly as much lies the lowest carries the
    others. None for a front alone that nothing is above, and for a foot:
    part of what it stands on.

    Args:
        box: of the points. distance: of the camera, metres.
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
    peaks = (above >= np.roll(above, 1)) & (above >= np.roll(above, -1)) & is_level & (above >= NEARLY * above.max())
    peak = int(np.argmax(peaks if peaks.any() else above))
    height = low + (peak + 0.5) * (high - low) / bins
    higher = float((heights > height + thick).mean())
    is_front = not is_level[peak] and higher < STRAY
    is_foot = height < np.quantile(heights, STRAY) + thick and higher > 0.5
    return None if is_front or is_foot else height


def is_uppermost(points: NDArray[np.float64], box: UprightBox, thick: float) -> NDArray[np.bool_]:
    """Which points (N, 3) are the highest over their cell of an object's ground plan, or so many metres below that."""
    inside = (points - box.center) @ yaw_matrix(box.yaw)[:, :2] / np.maximum(box.size[:2], 1e-6) + 0.5
    row, column = np.clip((inside * CELLS).astype(int), 0, CELLS - 1).T
    _, cells, counts = np.unique(row * CELLS + column, return_inverse=True, return_counts=True)
    heights = points[np.lexsort((points[:, 2], cells)), 2]
    ends = heights[np.cumsum(counts) - np.minimum(counts, HIGHEST)]
    return np.asarray(points[:, 2] > ends[cells] - thick)


def is_topped(label: str) -> bool:
    """Whether things of this name are closed and end in a level top."""
    return _last_word(label) in TOPPED.split()


def is_seat(label: str) -> bool:
    """Whether people sit or lie on things of this name, and they stand on the floor."""
    return _last_word(label) in SEAT.split()


def carrying_heights(label: str, level: float | None, top: float) -> tuple[float, ...]:
    """Heights at which a thing of this name that reaches up to `top` may carry others, most of it first: a chair at its
    seat, a desk between its clutter, and on that."""
    return (top,) if level is None or _last_word(label) in OPEN.split() else (level, top)


def ending_near(carrier: UprightBox, heights: tuple[float, ...], bottom: float, reach: float) -> UprightBox:
    """A carrier's box, ending at the first of its heights within `reach` metres of the bottom of what it may carry."""
    near = next((height for height in heights if abs(height - bottom) < reach), None)
    return carrier if near is None else with_top(carrier, near)


def _last_word(label: str) -> str:
    words = re.findall(r"[a-z]+", label.lower())
    return words[-1].removesuffix("s") if words else ""
