"""Robust least squares, terms in their own deviations, some counted as Cauchy's; how points of a surface lie."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

TRIM = 0.005  # share of an exact cloud's points left out at either end of an extent; half of A.7's; chosen
BIN = 0.005  # metres: width of a bin of coordinates; chosen
SPREAD = 0.015  # metres by which points of a face spread without noise (panels, handles); chosen
REACH = 3.0  # standard deviations of noise: 99.7 % of the points of a face lie within
PROMINENT = 2.0  # times the mean density of points, from which on there is a face; chosen


UNUSUAL = 2.0  # deviations from which on what is seen counts less; chosen on `work`
LARGEST_CHANGE = 1.5  # logarithm: extents of a box never change by more
Array = NDArray[np.float64]


class Deviations(NamedTuple):
    """Deviations (M,), how much each counts (M,), and from where on it counts less (M,), inf: it is Gaussian."""

    off: Array
    share: Array
    unusual: Array

    @property
    def cost(self) -> float:
        """Of all of them: minus the logarithm of how likely they are."""
        square = np.where(np.isinf(self.unusual), 1.0, self.unusual) ** 2
        lost = np.where(np.isinf(self.unusual), self.off**2, square * np.log1p(self.off**2 / square))
        return float((self.share * lost).sum() / 2)


def find_step(
    measure: Callable[[Array], Deviations], state: Array, small: float, damping: Array
) -> tuple[Array, Array]:
    """A step (N,) of Gauss-Newton with Cauchy's weights, to be taken off a state (N,); and the curvature (N, N) there.

    Args:
        measure: the terms of a state.
        small: of each number, for differences.
        damping: (N,) added to the curvature.
    """
    now, *shifted = (measure(state + row) for row in small * np.eye(len(state) + 1, len(state), k=-1))
    jacobian = np.stack([(each.off - now.off) / small for each in shifted], axis=1)
    weights = now.share / (1 + (now.off / now.unusual) ** 2)
    curvature = jacobian.T @ (weights[:, None] * jacobian) + np.diag(damping)
    return np.asarray(np.linalg.solve(curvature, jacobian.T @ (weights * now.off))), curvature
