"""The box that lays a model, turned some way, over an object: rescaled, placed, normalised (paper B.1)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stages.contracts.objects import DepthError
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import SYMMETRY_PERIOD, yaw_matrix
from stages.matching.synthesis.observation import Observation
from stages.matching.synthesis.solid import Solid

TRIM = 0.005  # share of the points left out at each end
THIN = 0.005  # metres: no box is thinner
MOST_NOISE = 0.25  # of an extent: no more is taken off it at either end, far away the noise is only guessed
REACH = 2.0  # deviations by which the outermost points lie beyond a face
SEEN, UNSEEN = 0.1, 0.3  # of an extent: how far a face may be wrong, across the line of sight and behind the object
ROUNDS = 4
SIDE_ERROR = 0.005  # of the object's longer side in the picture: how well outlines meet
UNSURE = 2.0  # deviations from which on something counts less and less: a mask may lack legs, points be of other things
STRETCH = 0.5  # logarithm: how unlike the axes of a model may be stretched ...
TURNED = 0.05  # ... and its two level axes, if a quarter turn maps it onto itself
FARTHEST = 1.5  # logarithm: extents never change by more
Array = NDArray[np.float64]


class Measured(NamedTuple):
    """Ends (2, 3) of what is seen of an object along axes turned by `yaw`, and how far each may be wrong, metres."""

    ends: Array
    errors: Array
    yaw: float

    def box(self) -> UprightBox:
        """The box between the ends."""
        return UprightBox(yaw_matrix(self.yaw) @ self.ends.mean(axis=0), self.ends[1] - self.ends[0], self.yaw)


def measure(
    cloud: Array,
    heights: tuple[float, float],
    yaw: float,
    eye: Array,
    depth_error: DepthError,
    behind: tuple[Array, float] | None = None,
) -> Measured:
    """The extents of a cloud (N, 3), floor frame, along axes turned by `yaw`, and between two heights.

    Noise of depth lays points before and behind the faces: taken off, as far as the axes run along the line of sight.

    Args:
        behind: normal (3,) and offset of the wall that the object reaches to, further than its points may tell.
    """
    turn = yaw_matrix(yaw)[:2, :2]
    level = np.quantile(cloud[:, :2] @ turn, [TRIM, 1 - TRIM], axis=0)
    sight = (cloud.mean(axis=0) - eye)[:2] @ turn
    distance = float(np.linalg.norm(sight))
    along = sight / max(distance, 1e-6)
    noise = REACH * depth_error.at(distance) * np.abs(along)
    inset = np.minimum(noise, MOST_NOISE * (level[1] - level[0]))
    level += [inset, -inset]
    extent = np.maximum(level[1] - level[0], THIN)
    share = np.array([SEEN + UNSEEN * np.clip(-along, 0, 1), SEEN + UNSEEN * np.clip(along, 0, 1)])
    errors = share * extent + noise
    if behind is not None:
        normal = behind[0][:2] @ turn
        axis = int(np.argmax(np.abs(normal)))
        end = 0 if normal[axis] > 0 else 1
        wall = behind[1] * np.sign(normal[axis])
        errors[end, axis] = SEEN * extent[axis] + abs(wall - level[end, axis]) / 2
        level[end, axis] = wall
    level = np.sort(level, axis=0)
    thin = np.maximum(THIN - (level[1] - level[0]), 0) / 2
    level += [-thin, thin]
    height = max(heights[1] - heights[0], THIN)
    ends = np.column_stack([level, [heights[0], heights[0] + height]])
    return Measured(ends, np.column_stack([errors, [SEEN * height] * 2]), yaw)


def laid_over(solid: Solid, measured: Measured, seen: Observation) -> UprightBox:
    """The box, changed as little as makes the model's outline reach the same sides of the picture as the mask.

    Gauss-Newton over place and logarithms of the extents; what picture and points leave open, the model's own
    proportions settle. Sides that are hidden or cut off say nothing; what contradicts all the rest says little (weights
    of Cauchy's distribution, by which errors are mostly small and sometimes of any size).
    """
    turn, start = yaw_matrix(measured.yaw), measured.box()
    center, size = measured.ends.mean(axis=0), np.asarray(start.size, dtype=float)
    longer = float(np.max(seen.sides[2:] - seen.sides[:2]))
    native = np.maximum(solid.asset.size, THIN)
    level = TURNED if SYMMETRY_PERIOD[solid.asset.symmetry] < np.pi else STRETCH

    def residuals(change: Array) -> Array:
        middle, extents = center + change[:3] * size, size * np.exp(change[3:])
        pixels = seen.pixels(solid.placed(UprightBox(turn @ middle, extents, measured.yaw)))
        sides = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
        off = (sides - seen.sides)[seen.free] / longer
        ends = np.array([middle - extents / 2, middle + extents / 2])
        x, y, z = np.log(extents / native)
        stretch = [(x - y) / level, (z - (x + y) / 2) / STRETCH]
        return np.concatenate([off / SIDE_ERROR, ((ends - measured.ends) / measured.errors).ravel(), stretch])

    change, small = np.zeros(6), 1e-3
    for _ in range(ROUNDS):
        now = residuals(change)
        jacobian = np.stack([(residuals(change + row) - now) / small for row in small * np.eye(6)], axis=1)
        trust = 1 / np.sqrt(1 + (now / UNSURE) ** 2)
        step = np.linalg.lstsq(jacobian * trust[:, None], now * trust, rcond=None)[0]
        change = (change - step).clip(-FARTHEST, FARTHEST)
    return UprightBox(turn @ (center + change[:3] * size), size * np.exp(change[3:]), measured.yaw)
