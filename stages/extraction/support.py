"""What carries an object: another one, the floor, an unnamed surface, or nothing, as it hangs on a wall (A.2)."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stages.contracts.objects import Wall
from stages.contracts.types import FLOOR
from stages.extraction.visibility import CONTACT, DepthView, cell_centres
from stages.extraction.wall_contact import FREE_SHARE
from stages.geometry.boxes import UprightBox, footprint
from stages.geometry.frames import yaw_matrix
from stages.geometry.masks import OUTLINE, Mask

JUST_BELOW = 0.15  # metres; farther down furniture may stand before a picture that hangs; chosen
SUNK = 0.04  # share of the distance by which an object reaches below the top of what it is in (a can in a bowl); chosen


def find_carrier(
    box: UprightBox, carriers: Mapping[str, UprightBox], tolerance: float, sunk: float = np.inf, share: float = 0.5
) -> tuple[float, str]:
    """Top of the highest carrier below a box and its id, or that of the floor.

    Args:
        box: of the object.
        carriers: boxes by id.
        tolerance: gap in metres that counts as touching.
        sunk: an object that reaches so many metres, and half of its height, below a carrier's top lies in the
        carrier, not on it; its bottom is that of its own box.
        share: least share of the box's footprint that lies over the carrier's, or within touching distance of it.
    """
    inside = max(sunk, float(box.size[2]) / 2)
    plan, touching = footprint(box), min(CONTACT, float(np.min(box.size[:2])) / 4)
    tops = [
        (carrier.top if carrier.top <= box.bottom + inside else box.bottom, name)
        for name, carrier in carriers.items()
        if plan.intersection(footprint(carrier).buffer(touching)).area > share * plan.area
        and carrier.top <= box.bottom + 2 * tolerance
        and carrier.top + carrier.bottom < box.top + box.bottom
    ]
    return max(tops, default=(0.0, FLOOR))


def is_hanging(box: UprightBox, beneath: float, view: DepthView, own: Mask) -> bool:
    """Whether an object at a wall is seen to end above the height `beneath` of the surface below; `own`: pixels (H,
    W).

    Depth errs along the line of sight, so the lower edge is as sharp as the picture at any distance.
    """
    return (
        box.bottom - beneath > OUTLINE * view.pixel_size(view.distance(box.center))
        and not reaches_down(box, beneath, view, own)
        and measure_free_share(box, beneath, view, own) >= FREE_SHARE
    )


def measure_free_share(box: UprightBox, height: float, view: DepthView, own: Mask) -> float:
    """Share of the space just below the box, down to `height` at most, that the camera sees to be empty."""
    half = box.size[:2] / 2
    low = max(height, box.bottom - JUST_BELOW)
    local = cell_centres(np.array([*-half, low]), np.array([*half, box.bottom]), (6, 6, 8))
    return view.free_share(local @ yaw_matrix(box.yaw).T + [*box.center[:2], 0.0], own)


def reaches_down(box: UprightBox, height: float, view: DepthView, own: Mask) -> bool:
    """Whether the object is seen to stand at `height`: rays through its lowest pixels meet it inside the footprint.

    Legs are too thin to have trusted depth, but their ends are in the mask. The lowest pixels of what hangs on a wall
    have rays that meet the floor far behind it.
    """
    columns, lowest = lowest_pixels(own)
    hits = view.intersect_level(columns, lowest, height)
    return int(_is_over(hits, box, view.tolerance(box.center)).sum()) >= OUTLINE


def measure_shelf(box: UprightBox, walls: Sequence[Wall], view: DepthView, own: Mask, unnamed: Mask) -> float | None:
    """Height of an unnamed surface, e.g. a shelf, just below most of the object's lowest pixels; None: there is none.

    A wall carries nothing, whether it has a mask there or not.

    Args:
        box: of what was seen of the object, at its `own` pixels (H, W).
        unnamed: pixels (H, W) of no mask.
    """
    tolerance = view.tolerance(box.center)
    columns, rows = lowest_pixels(own)
    inside = rows + 2 * OUTLINE < own.shape[0]
    columns, rows = columns[inside], rows[inside] + OUTLINE
    shown = unnamed[rows, columns] & unnamed[rows + OUTLINE, columns] & (view.depth[rows, columns] > 0)
    points = view.points[rows[shown], columns[shown]]
    near = _is_over(points, box, 2 * tolerance) & (np.abs(points[:, 2] - box.bottom) < tolerance)
    for wall in walls:
        near &= points @ np.array(wall.normal) - wall.offset > tolerance
    return float(np.median(points[near, 2])) if near.sum() > len(columns) / 2 else None


def lowest_pixels(own: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns (N,) and rows (N,) of the lowest pixel of a mask (H, W) in each column."""
    columns = np.flatnonzero(own.any(axis=0))
    return columns, own.shape[0] - 1 - np.argmax(own[::-1, columns], axis=0)


def _is_over(points: NDArray[np.float64], box: UprightBox, margin: float) -> Mask:
    """Which points (N, 3) lie over the footprint of a box, widened by `margin` metres."""
    local = (points - box.center) @ yaw_matrix(box.yaw)
    return np.asarray((np.abs(local[:, :2]) <= box.size[:2] / 2 + margin).all(axis=1))
