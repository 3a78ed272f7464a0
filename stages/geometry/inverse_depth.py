"""Whether a depth image holds depth or its inverse (disparity), as relative networks and stereo give it."""

import numpy as np
from numpy.typing import NDArray

from stages.geometry.frames import SAMPLED

HYPOTHESES, PLANES = 300, 3  # three-point hypotheses a plane, planes; chosen for time
TOLERANCE = 0.02  # share of its value by which a point may be off a plane, and of points more on planes; chosen


def is_inverse(depth: NDArray[np.floating]) -> bool:
    """Whether values (H, W; 0: unknown) are larger in the lower half, and are planar where their inverses are not.

    In pictures of rooms and tables the lower half is nearer than the upper. On a plane inverse depth is linear in
    the pixel, depth is not.
    """
    rng = np.random.default_rng(0)
    rows, columns = np.nonzero(depth > 0)
    if len(rows) < SAMPLED:
        return False
    chosen = rng.choice(len(rows), SAMPLED, replace=False)
    rows, columns = rows[chosen], columns[chosen]
    values = depth[rows, columns].astype(np.float64)
    is_lower = rows > np.median(rows)
    if not is_lower.any() or np.median(values[is_lower]) < np.median(values[~is_lower]):
        return False
    pixels = np.column_stack([columns, rows, np.ones(SAMPLED)]).astype(np.float64)
    return count_planar(values, pixels, rng) > (1 + TOLERANCE) * count_planar(1 / values, pixels, rng)


def count_planar(
    values: NDArray[np.float64], pixels: NDArray[np.float64], rng: np.random.Generator, off: float = TOLERANCE
) -> int:
    """How many of the values (N,) a few planes explain as linear in the homogeneous pixels (N, 3).

    `off`: tolerance, as a share of the value.
    """
    found = 0
    for _ in range(PLANES):
        if len(values) < 3:
            break
        three = rng.integers(len(values), size=(HYPOTHESES, 3))
        three = three[np.abs(np.linalg.det(pixels[three])) > 0.5]  # whole pixels: twice the area of the triangle
        if not len(three):
            break
        planes = np.linalg.solve(pixels[three], values[three][..., None])[..., 0]
        on = np.abs(pixels @ planes.T - values[:, None]) < off * values[:, None]
        best = on[:, np.argmax(on.sum(axis=0))]
        found += int(best.sum())
        values, pixels = values[~best], pixels[~best]
    return found
