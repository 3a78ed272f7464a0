"""The z-aligned minimum box of a cloud (paper A.7, orientation refinement)."""

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import SAMPLED, wrap_angle, yaw_matrix

COARSE_STEP = np.deg2rad(1.0)
FINE_STEP = np.deg2rad(0.1)
AREA_TIE = 1.1  # times the smallest footprint, up to which points on the sides decide; chosen
SIDE_CLIP = 0.05  # metres, beyond which a point says nothing about a side; chosen


def _extents(points: NDArray[np.float64], yaw: float, trim: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points in the axes turned by `yaw`, and their (2, d) trimmed bounds."""
    turned = points @ yaw_matrix(yaw)[: points.shape[1], : points.shape[1]]
    return turned, np.quantile(turned, [trim, 1 - trim], axis=0)


def _area_and_misfit(points: NDArray[np.float64], yaw: float, trim: float) -> tuple[float, float]:
    """Footprint area, and mean distance of the points to the nearest side of the footprint."""
    turned, (low, high) = _extents(points, yaw, trim)
    to_side = np.minimum(np.abs(turned - low), np.abs(turned - high)).min(axis=1)
    return float(np.prod(high - low)), float(np.minimum(to_side, SIDE_CLIP).mean())


def _best_yaw(points: NDArray[np.float64], yaws: NDArray[np.float64], trim: float) -> float:
    """The yaw of the smallest footprint; near-ties go to the one whose sides the points lie on.

    A box of which two side faces are seen gives an L from above, and the smallest rectangle around
    an L is not unique: the one along its hypotenuse has exactly the same area.
    """
    areas, misfits = np.array([_area_and_misfit(points, yaw, trim) for yaw in yaws]).T
    tied = areas <= AREA_TIE * areas.min() + 1e-9
    return float(yaws[tied][np.argmin(misfits[tied])])


def minimum_box(points: NDArray[np.floating], trim: float = 0.0) -> UprightBox:
    """The z-aligned box with the smallest footprint that holds the points (N, 3).

    Args:
        points: cloud in a frame with z up, at least one point.
        trim: fraction of the points left out at either end of each box axis, so that a few
            stray points do not decide the extents. 0: the true bounding box.

    Returns:
        the box, with yaw in (-pi/4, pi/4]: its x axis is the side nearest to the frame's x axis.
    """
    cloud = np.asarray(points, dtype=np.float64)
    plan = cloud[:: max(1, len(cloud) // SAMPLED), :2]
    yaw = _best_yaw(plan, np.arange(-np.pi / 4 + COARSE_STEP, np.pi / 4 + COARSE_STEP / 2, COARSE_STEP), trim)
    yaw = _best_yaw(plan, yaw + np.arange(-COARSE_STEP, COARSE_STEP + FINE_STEP / 2, FINE_STEP), trim)
    yaw = wrap_angle(yaw, np.pi / 2)
    _, (low, high) = _extents(cloud, yaw, trim)
    return UprightBox(yaw_matrix(yaw) @ ((low + high) / 2), high - low, yaw)
