"""The box that lays a model, turned some way, over an object: rescaled, placed, normalised (paper B.1)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.render_and_compare.observation import NoisyCloud, ObservedGrid
from roomkin.plugins.render_and_compare.rendering import ColoredSolid
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import SYMMETRY_PERIOD, yaw_matrix
from roomkin.stages.geometry.robust import BIN, LARGEST_CHANGE, TRIM, UNUSUAL, Deviations, find_step

OUTERMOST = 2.0  # deviations of noise by which these lie beyond a face; chosen
SEEN, UNSEEN = 0.1, 0.3  # of an extent: deviation of any face, and how much more of the hidden one; chosen
ROUNDS = 4  # of Gauss-Newton steps; chosen for time
SIDE_ERROR = 0.005  # of the object's longer side in the picture: how well outlines meet; chosen
STRETCH = 0.5  # deviation of the logarithm of one axis' scale over another's ...
TURNED = 0.05  # ... and of the two level ones, if a quarter turn maps the model onto itself; chosen
Array = NDArray[np.float64]


class Measured(NamedTuple):
    """Ends (2, 3) of what is seen of an object along axes turned by `yaw`, and how far each may be wrong, metres."""

    ends: Array
    errors: Array
    yaw: float

    def box(self) -> UprightBox:
        """The box between the ends."""
        size = np.maximum(self.ends[1] - self.ends[0], BIN)
        return UprightBox(yaw_matrix(self.yaw) @ self.ends.mean(axis=0), size, self.yaw)


def measure(sight: NoisyCloud, box: UprightBox, yaw: float, wall: tuple[Array, float] | None = None) -> Measured:
    """The extents of an object along axes turned by `yaw`, with the heights of its box.

    Args:
        box: the minimum box of its points, down to what it stands on.
        wall: normal (3,) and offset of the wall that the object reaches to, further than its points may tell.
    """
    turn = yaw_matrix(yaw)[:2, :2]
    level = sight.measure_ends(yaw, TRIM, OUTERMOST)
    ends = np.column_stack([level, [box.bottom, box.top]])
    extent = np.maximum(ends[1] - ends[0], BIN)
    along, noise = np.append(sight.ray[:2] @ turn, 0.0), np.append(sight.noise_along(yaw), 0.0)
    errors = (SEEN + UNSEEN * np.clip([-along, along], 0, 1)) * extent + OUTERMOST * noise
    if wall is not None:
        normal = wall[0][:2] @ turn
        axis = int(np.argmax(np.abs(normal)))
        end = 0 if normal[axis] > 0 else 1
        there = wall[1] * np.sign(normal[axis])
        errors[end, axis] = SEEN * extent[axis] + abs(there - ends[end, axis]) / 2
        ends[end, axis] = there
    order = np.argsort(ends, axis=0)  # the wall may stand before the near end
    return Measured(np.take_along_axis(ends, order, axis=0), np.take_along_axis(errors, order, axis=0), yaw)


def lay_over(solid: ColoredSolid, measured: Measured, seen: ObservedGrid) -> UprightBox:
    """The box whose outline in the picture reaches the sides of the mask, near the measured one.

    Gauss-Newton over place and logarithms of the extents, with Cauchy's weights. Three kinds of residuals: sides of
    the outline against those of the mask (neither hidden nor cut off), ends against the measured ones, and scales of
    the axes against each other, which keep the model's proportions where nothing else decides.
    """
    turn, start = yaw_matrix(measured.yaw), measured.box()
    center, size = measured.ends.mean(axis=0), start.size
    longer = float(np.max(seen.sides[2:] - seen.sides[:2]))
    native = np.maximum(solid.asset.size, BIN)
    level = TURNED if SYMMETRY_PERIOD[solid.asset.symmetry] < np.pi else STRETCH

    def compare(change: Array) -> Deviations:
        middle, extents = center + change[:3] * size, size * np.exp(change[3:])
        pixels = seen.project(solid.place_outline(UprightBox(turn @ middle, extents, measured.yaw)))
        sides = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
        off = (sides - seen.sides)[seen.free] / longer
        ends = np.array([middle - extents / 2, middle + extents / 2])
        x, y, z = np.log(extents / native)
        stretch = [(x - y) / level, (z - (x + y) / 2) / STRETCH]
        terms = np.concatenate([off / SIDE_ERROR, ((ends - measured.ends) / measured.errors).ravel(), stretch])
        return Deviations(terms, np.ones(len(terms)), np.full(len(terms), UNUSUAL))

    change = np.zeros(6)
    for _ in range(ROUNDS):
        step, _ = find_step(compare, change, 1e-3, np.zeros(6))
        change = (change - step).clip(-LARGEST_CHANGE, LARGEST_CHANGE)
    return UprightBox(turn @ (center + change[:3] * size), size * np.exp(change[3:]), measured.yaw)
