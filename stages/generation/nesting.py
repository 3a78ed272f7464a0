"""At which height a thing comes to rest in another: a can in a bowl. The paper (A.3) only moves things sideways."""

from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

Piece = NDArray[np.float64]  # (n, 3): vertices of a convex piece


def overlap_height(upper: Piece, lower: Piece) -> float | None:
    """How far `lower` reaches above the underside of `upper`, at worst, metres; None: nowhere is one above the other.

    The highest point of one hull above the lowest of the other at the same x and y: a linear programme in the weights
    of the vertices of both.
    """
    if (upper[:, :2].min(0) > lower[:, :2].max(0)).any() or (lower[:, :2].min(0) > upper[:, :2].max(0)).any():
        return None
    n, m = len(upper), len(lower)
    same_place = np.hstack([upper[:, :2].T, -lower[:, :2].T])
    weights = np.vstack([np.repeat([1.0, 0.0], [n, m]), np.repeat([0.0, 1.0], [n, m])])
    found = linprog(
        np.concatenate([upper[:, 2], -lower[:, 2]]), A_eq=np.vstack([same_place, weights]), b_eq=[0.0, 0.0, 1.0, 1.0]
    )
    return -float(found.fun) if found.success else None


def find_landing(upper: list[Piece], lower: list[Piece]) -> float | None:
    """How far `upper` rises (metres; negative: sinks) to lie on or in `lower`, let down from above.

    Args:
        upper, lower: convex pieces of both, in one frame, z up.

    Returns:
        None if neither is above the other anywhere.
    """
    heights = [overlap_height(a, b) for a, b in product(upper, lower)]
    return max((height for height in heights if height is not None), default=None)
