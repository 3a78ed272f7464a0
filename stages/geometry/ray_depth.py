"""Conversion of distances along rays, as many simulators write them, to depth along the optical axis."""

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import SAMPLED
from roomkin.stages.geometry.inverse_depth import count_planar

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
