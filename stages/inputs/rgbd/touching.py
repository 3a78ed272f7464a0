"""Things that touch or hide each other, cut apart: at steps of depth, and where their surfaces meet concavely.

Local convexity as in Stein et al. (CVPR 2014), along edges of the image rather than between supervoxels.
"""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.spatial import KDTree

from stages.geometry.clouds import surface_normals
from stages.inputs.rgbd.pieces import STEP, Surface, joined

COLUMNS = 320  # pixels across at which edges are sought: at most twice as many
APART, RADIUS = 3, 0.01  # pixels to either side of a crease; metres at 1 m of the surface that has a normal
NOISE = 0.02  # share of the distance that smoothing may change
CONCAVE = np.deg2rad(50)  # by which surfaces on either side turn towards each other
SMALLEST = 0.0015  # of the picture: what is smaller is a part of what is nearest


def smoothed(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth (H, W) without speckles; what is farther from the median around it than noise is left as it is."""
    median = cv2.medianBlur(depth, 5)
    return np.where(np.abs(median - depth) < NOISE * depth, median, depth)


def cut_apart(
    values: NDArray[np.uint16], points: NDArray[np.float64], height: NDArray[np.float64], lowest: float
) -> NDArray[np.uint16]:
    """Masks (H, W), each cut into what a person would call things; 0: nothing. From left to right as before.

    Args:
        values: masks of heaps. points: (H, W, 3), camera frame, z = 0: unknown.
        height: (H, W) above what they stand on. lowest: metres; below it noise of that shows, which tells nothing.
    """
    stride = max(1, values.shape[1] // COLUMNS)
    coarse, some, tall = values[::stride, ::stride], points[::stride, ::stride], height[::stride, ::stride]
    seen = (coarse > 0) & (some[..., 2] > 0)
    normals = np.zeros(some.shape)
    normals[seen] = surface_normals(some[seen], RADIUS * float(np.median(some[seen][:, 2])))
    inner = (seen & (tall > lowest) & ~_steps(some[..., 2], seen) & ~_creases(some, normals, seen)).astype(np.uint8)
    parts = np.zeros(values.shape, np.uint16)
    count = 0
    for value in np.unique(values[values > 0]):
        _, labels, stats, _ = cv2.connectedComponentsWithStats(inner * (coarse == value), connectivity=4)
        large = 1 + np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= SMALLEST * coarse.size)
        mask = values == value
        if len(large) < 2:
            count += 1
            parts[mask] = count
            continue
        core = np.isin(labels, large)
        _, nearest = KDTree(some[core]).query(points[mask])
        parts[mask] = count + 1 + np.searchsorted(large, labels[core])[nearest]
        count += len(large)
    shown = np.where(seen, parts[::stride, ::stride], 0)
    for value, other in joined(shown, coarse, Surface(some, normals, tall), lowest):
        parts[parts == value] = other
    return parts


def _steps(depth: NDArray[np.float64], seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels (H, W) next to which depth changes by a step."""
    far = maximum_filter(np.where(seen, depth, 0), 3)
    near = minimum_filter(np.where(seen, depth, np.inf), 3)
    return np.maximum(far - depth, depth - near) > STEP * depth


def _creases(points: NDArray[np.float64], normals: NDArray[np.float64], seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels (H, W) on either side of which surfaces turn towards each other, in any of four directions."""
    least = 2 * np.sin(CONCAVE / 2)
    found = np.zeros(seen.shape, bool)
    for dy, dx in ((0, APART), (APART, 0), (APART, APART), (APART, -APART)):
        (there, other), (ahead, behind) = (
            [np.roll(array, (sign * dy, sign * dx), (0, 1)) for sign in (-1, 1)] for array in (points, normals)
        )
        both = np.roll(seen, (-dy, -dx), (0, 1)) & np.roll(seen, (dy, dx), (0, 1))
        along = there - other
        length = np.linalg.norm(along, axis=-1)
        turn = ((ahead - behind) * along).sum(axis=-1)
        found |= both & (turn < -least * length)
    return found
