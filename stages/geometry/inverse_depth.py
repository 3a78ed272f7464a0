"""Whether a depth image holds depth, a z-buffer, or disparity, as relative networks and stereo give it."""

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import SAMPLED

HYPOTHESES, PLANES = 300, 3  # three-point hypotheses a plane, planes; chosen for time
CROWDED = (
    0.95  # all values of a z-buffer with a near plane of 2 cm are above it; in metres that is nearly a plane; chosen
)
BENDS = 16  # lengths of a bend in a picture's width; chosen
ROUNDED = 1e-6  # bends of numbers with 32 bits are noise below it
FLAT = 0.05  # share of the bends
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


def is_zbuffer(values: NDArray[np.floating]) -> bool:
    """Whether values (H, W; 0: unknown) are of a z-buffer: within 0..1, and all near 1 or flat where planes are.

    A z-buffer is linear in 1 / z, so that on a plane it is linear in the pixel, and the inverse of its values is not.
    So is inverse depth: ask for that first.
    """
    known = values[values > 0]
    if not known.size or known.max() > 1 + ROUNDED or known.min() == known.max():
        return False
    if np.quantile(known, 0.01) > CROWDED:
        return True
    apart = max(1, values.shape[1] // BENDS)
    bends = []
    for numbers in (values.astype(np.float64), values[:, ::-1].T.astype(np.float64)):
        before, here, after = numbers[:, : -2 * apart], numbers[:, apart:-apart], numbers[:, 2 * apart :]
        there = (before > 0) & (here > 0) & (after > 0)
        before, here, after = before[there], here[there], after[there]
        bent = np.abs(before + after - 2 * here)
        bends.append(np.stack([bent, np.abs(1 / before + 1 / after - 2 / here) * here**2]))
    as_is, inverse = np.concatenate(bends, axis=1)
    seen = np.maximum(as_is, inverse) > ROUNDED
    flat, other = (float((seen & (2 * one < two)).mean()) for one, two in ((as_is, inverse), (inverse, as_is)))
    return flat > FLAT and flat > 2 * other


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
