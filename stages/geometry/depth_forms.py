"""What a depth image may hold besides metres along the axis: marks, z-buffers, disparity, distances along rays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import SAMPLED

# Chosen; what they find on frames of cameras is in docs/results/your-data.md.
MIN_PIXELS = 20  # that share a value; one of fewer may be a distance
MIN_VALUES = 100  # different other values; depth with fewer is drawn or made of planes
SET_APART = 2.0  # times as far as everything else, or as near


def find_marks(values: NDArray[Any]) -> list[float]:
    """Values above 0 that mean `unknown` in depth (h, w): the largest of the type, and one that many pixels share, at
    least twice as far as all others or at most half as far.
    """
    found, counts = count_values(values)
    marks: list[float] = []
    if len(found) > 1 and values.dtype.kind in "iu" and found[-1] == np.iinfo(values.dtype).max:
        marks, found, counts = [float(found[-1])], found[:-1], counts[:-1]
    while len(found) > MIN_VALUES:
        if counts[-1] >= MIN_PIXELS and found[-1] >= SET_APART * found[-2]:
            marks, found, counts = [*marks, float(found[-1])], found[:-1], counts[:-1]
        elif counts[0] >= MIN_PIXELS and found[1] >= SET_APART * found[0]:
            marks, found, counts = [*marks, float(found[0])], found[1:], counts[1:]
        else:
            break
    return marks


def remove_marks(values: NDArray[Any], marks: list[float]) -> NDArray[Any]:
    """The values (h, w), with 0 in place of the marks."""
    return np.where(np.isin(values, np.asarray(marks, dtype=values.dtype)), 0, values) if marks else values


def count_values(values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """The known values above 0 of depth (h, w) in ascending order, and how many pixels have each."""
    found, counts = np.unique(values[np.isfinite(values) & (values > 0)], return_counts=True)
    return found, counts


HYPOTHESES, PLANES = 300, 3  # three-point hypotheses a plane, planes; chosen for time
CROWDED = 0.95  # all values of a z-buffer with a near plane of 2 cm are above; in metres nearly a plane; chosen
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


OFF_PLANE = 0.01  # share of its value by which a point may be off a plane; chosen
MORE_PLANAR = 1.3  # times as many points on planes, above which depth is taken to be of the other kind; chosen


def ray_lengths(shape: tuple[int, int], intrinsics: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length (H, W) of each pixel's ray from the camera to the plane z = 1, for K (3, 3)."""
    v, u = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    x, y = (u - intrinsics[0, 2]) / intrinsics[0, 0], (v - intrinsics[1, 2]) / intrinsics[1, 1]
    return np.asarray(np.sqrt(x**2 + y**2 + 1))


def along_axis(distance: NDArray[np.float32], intrinsics: NDArray[np.float64]) -> NDArray[np.float32]:
    """Convert distances (H, W) along the rays of K (3, 3) to depth (H, W) along the optical axis."""
    return (distance / ray_lengths(distance.shape, intrinsics)).astype(np.float32)


def find_flatter(depth: NDArray[np.floating], intrinsics: NDArray[np.float64]) -> str:
    """How depth (H, W; 0: unknown) makes floor and walls flatter: converted from `ray` to axis, or from `axis` to ray;
    empty: as it is. K (3, 3). On a plane 1 / z is linear in the pixel.
    """
    rows, columns = np.nonzero(depth > 0)
    if len(rows) < SAMPLED:
        return ""
    chosen = np.random.default_rng(0).choice(len(rows), SAMPLED, replace=False)
    rows, columns = rows[chosen], columns[chosen]
    inverse = 1 / depth[rows, columns].astype(np.float64)
    lengths = ray_lengths(depth.shape, intrinsics)[rows, columns]
    pixels = np.column_stack([columns, rows, np.ones(SAMPLED)]).astype(np.float64)
    kinds = {"": inverse, "ray": inverse * lengths, "axis": inverse / lengths}
    flat = {kind: count_planar(values, pixels, np.random.default_rng(0), OFF_PLANE) for kind, values in kinds.items()}
    best = max(flat, key=lambda kind: flat[kind])
    return best if flat[best] > MORE_PLANAR * flat[""] else ""
