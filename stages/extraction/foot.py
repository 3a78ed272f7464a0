"""The foot of an object in the picture: whether it reaches the ground, or which unlabelled surface it stands on."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stages.contracts.objects import Wall
from stages.extraction.masks import OUTLINE
from stages.extraction.visibility import DepthView
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

SHELF = 0.5  # share of the pixels just below an object that must show what it stands on


def lowest_pixels(own: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns (N,) and rows (N,) of the lowest pixel of a mask (H, W) in each column."""
    columns = np.flatnonzero(own.any(axis=0))
    return columns, own.shape[0] - 1 - np.argmax(own[::-1, columns], axis=0)


def height_shown(
    box: UprightBox,
    walls: Sequence[Wall],
    view: DepthView,
    own: NDArray[np.bool_],
    unnamed: NDArray[np.bool_],
    tolerance: float,
) -> float | None:
    """Height of an unlabelled surface just below the lowest pixels of the object, e.g. a shelf; None: there is none.

    A wall carries nothing, whether it is labelled there or not.
    """
    columns, rows = lowest_pixels(own)
    inside = rows + 2 * OUTLINE < own.shape[0]
    columns, rows = columns[inside], rows[inside] + OUTLINE
    shown = unnamed[rows, columns] & unnamed[rows + OUTLINE, columns] & (view.depth[rows, columns] > 0)
    points = view.points(columns[shown], rows[shown])
    local = (points - box.center) @ yaw_matrix(box.yaw)
    near = (np.abs(local[:, :2]) <= box.size[:2] / 2 + 2 * tolerance).all(axis=1)
    near &= np.abs(points[:, 2] - box.bottom) < tolerance
    for wall in walls:
        near &= points @ np.array(wall.normal) - wall.offset > tolerance
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
