"""The foot of an object in the picture: how far down the object reaches, and which unlabelled surface it stands on."""

import numpy as np
from numpy.typing import NDArray

from stages.extraction.clouds import with_bottom
from stages.extraction.masks import OUTLINE
from stages.extraction.visibility import DepthView
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

SHELF = 0.5  # share of the pixels just below an object that must show what it stands on
SHORT, SHORT_SHARE = 10, 0.25  # pixels, or share of its rows, by which a mask may end above its thing's foot
UNLIKE = 0.05  # metres: what is farther from where a thing or its ground would be is neither


def lowest_pixels(own: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns (N,) and rows (N,) of the lowest pixel of a mask (H, W) in each column."""
    columns = np.flatnonzero(own.any(axis=0))
    return columns, own.shape[0] - 1 - np.argmax(own[::-1, columns], axis=0)


def completed(
    box: UprightBox, view: DepthView, own: NDArray[np.bool_], unnamed: NDArray[np.bool_], tolerance: float
) -> tuple[UprightBox, NDArray[np.bool_]]:
    """The box and the mask of an object, down to its foot where unnamed pixels go on straight down from its own.

    Masks end some pixels too high. Of all rows in which the thing may end, the one that explains best what is below:
    upright down to it, level from there on. Where no end is near, something else may go on: nothing is changed.
    """
    columns, rows = lowest_pixels(own)
    above = view.points(columns, rows - OUTLINE)
    start = (rows >= OUTLINE) & np.isfinite(above[:, 2]) & (above[:, 2] < box.bottom + 2 * tolerance)
    columns, rows, above = columns[start], rows[start], above[start]
    count = max(SHORT, round(SHORT_SHARE * float(np.ptp(np.flatnonzero(own.any(axis=1))))))
    below = rows + np.arange(1, count + 1)[:, None]  # (count, N)
    there = np.minimum(below, own.shape[0] - 1)
    open_ = np.logical_and.accumulate(
        (below < own.shape[0]) & unnamed[there, columns] & (view.depth[there, columns] > 0)
    )
    if not open_.any():
        return box, own
    heights = view.points(np.broadcast_to(columns, there.shape)[open_], there[open_])[:, 2]
    upright = view.height_at(columns, np.concatenate([rows[None], below]), above)  # (count + 1, N): row 0 is the mask's
    limit = UNLIKE + 3 * view.noise(box.center)
    k, n = np.nonzero(open_)
    costs = [np.minimum(np.abs(heights - upright[np.minimum(k + 1, end), n]), limit).mean() for end in range(count + 1)]
    end = int(np.argmin(costs))
    first = k < max(end, 1)
    down, level = (np.abs(heights - upright[row, n])[first] for row in (k + 1, 0))
    if end in (0, count) or np.median(down) >= np.median(level):
        return box, own
    own = own.copy()
    kept = open_[:end]
    own[there[:end][kept], np.broadcast_to(columns, kept.shape)[kept]] = True
    return with_bottom(box, max(0.0, box.bottom - float(np.median(upright[0] - upright[end])))), own


def height_shown(
    box: UprightBox, view: DepthView, own: NDArray[np.bool_], unnamed: NDArray[np.bool_], tolerance: float
) -> float | None:
    """Height of an unlabelled surface just below the lowest pixels of the object, e.g. a shelf; None: there is none."""
    columns, rows = lowest_pixels(own)
    inside = rows + 2 * OUTLINE < own.shape[0]
    columns, rows = columns[inside], rows[inside] + OUTLINE
    shown = unnamed[rows, columns] & unnamed[rows + OUTLINE, columns] & (view.depth[rows, columns] > 0)
    points = view.points(columns[shown], rows[shown])
    local = (points - box.center) @ yaw_matrix(box.yaw)
    near = (np.abs(local[:, :2]) <= box.size[:2] / 2 + 2 * tolerance).all(axis=1)
    near &= np.abs(points[:, 2] - box.bottom) < tolerance
    return float(np.median(points[near, 2])) if near.sum() > SHELF * len(columns) else None


def reaches_down(box: UprightBox, height: float, tolerance: float, view: DepthView, own: NDArray[np.bool_]) -> bool:
    """Whether the object is seen to stand at `height`: rays through its lowest pixels meet it inside the footprint.

    Legs are too thin to have trusted depth, but their feet are in the mask. What hangs on a wall has
    its lowest pixels' rays meet the floor far behind it.
    """
    columns, lowest = lowest_pixels(own)
    hits = view.intersect_level(columns, lowest, height)
    local = (hits - box.center) @ yaw_matrix(box.yaw)
    inside = (np.abs(local[:, :2]) <= box.size[:2] / 2 + tolerance).all(axis=1)
    return int(inside.sum()) >= OUTLINE
