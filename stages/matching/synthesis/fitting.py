"""The box that lays a model, turned some way, over an object: rescaled, placed, normalised (paper B.1)."""

import numpy as np
from numpy.typing import NDArray

from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix
from stages.matching.synthesis.observation import Observation
from stages.matching.synthesis.solid import Solid

TRIM = 0.005  # share of the points left out at each end
THIN = 0.005  # metres: no box is thinner
ROUNDS = 3
SIDE_ERROR = 0.005  # of the object's longer side in the picture: how well outlines meet
EXTENT_ERROR = 0.15  # of its extents: how far measured extents and place may be wrong
FARTHEST = 0.6  # logarithm: extents never change by more
Array = NDArray[np.float64]


def measured_box(cloud: Array, heights: tuple[float, float], yaw: float) -> UprightBox:
    """The box along axes turned by `yaw` around a cloud (N, 3), between two heights."""
    turn = yaw_matrix(yaw)[:2, :2]
    low, high = np.quantile(cloud[:, :2] @ turn, [TRIM, 1 - TRIM], axis=0)
    size = np.maximum([*(high - low), heights[1] - heights[0]], THIN)
    return UprightBox(np.array([*(turn @ (low + high) / 2), sum(heights) / 2]), size, yaw)


def laid_over(solid: Solid, box: UprightBox, seen: Observation) -> UprightBox:
    """The box, changed as little as makes the model's outline reach the same sides of the picture as the mask.

    Gauss-Newton over place and logarithms of the extents. Sides that are hidden or cut off say nothing.
    """
    turn, size, center = yaw_matrix(box.yaw), np.asarray(box.size, dtype=float), np.asarray(box.center, dtype=float)
    longer = float(np.max(seen.sides[2:] - seen.sides[:2]))

    def changed(change: Array) -> UprightBox:
        return UprightBox(center + turn @ (change[:3] * size), size * np.exp(change[3:]), box.yaw)

    def residuals(change: Array) -> Array:
        pixels = seen.pixels(solid.placed(changed(change)))
        sides = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
        off = (sides - seen.sides)[seen.free] / longer
        return np.concatenate([off / SIDE_ERROR, change / EXTENT_ERROR])

    change, small = np.zeros(6), 1e-3
    for _ in range(ROUNDS):
        start = residuals(change)
        jacobian = np.stack([(residuals(change + row) - start) / small for row in small * np.eye(6)], axis=1)
        change = (change - np.linalg.lstsq(jacobian, start, rcond=None)[0]).clip(-FARTHEST, FARTHEST)
    return changed(change)
