"""Extents of a cloud along given axes: where its near faces are, not where its noise ends."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d

from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

BIN, SMOOTHING = 0.005, 3.0  # metres; bins
PROMINENT = 2.0  # a face is where points lie so many times denser than on average
NEAR_NOISE, FAR_NOISE = 0.05, 0.0035  # metres, 1 / metres: how far the outermost points may lie before their face


def noise_reach(distance: float) -> float:
    """How far outliers stray along the line of sight, metres: depth errs with the square of the distance."""
    return max(NEAR_NOISE, FAR_NOISE * distance**2)


def near_end(values: NDArray[np.float64], sign: float, reach: float, trim: float) -> float:
    """The end of the points on the side `sign` (1: high, -1: low) of an axis, the one towards the camera.

    It may be a face: many points then lie at one coordinate, spread by the noise of depth, and the
    outermost ones are two standard deviations in front of it. A face is where the points are densest,
    within `reach` of their end; without one the end is a quantile.

    Args:
        values: (N,) coordinates.
        trim: share of the points left out if the end is a quantile.
    """
    inward = -sign * values  # grows into the object
    low, high = np.quantile(inward, [trim, 1 - trim])
    bins = int((high - low) / BIN)
    if bins < 2:
        return float(-sign * low)
    counts, edges = np.histogram(inward, bins, (low, high))
    density = gaussian_filter1d(counts.astype(float), SMOOTHING, mode="constant")
    outer = density[: max(1, min(bins // 2, int(reach / BIN)))]
    peak = int(np.argmax(outer))
    if outer[peak] < PROMINENT * len(values) / bins:
        return float(-sign * low)
    return float(-sign * (edges[peak] + edges[peak + 1]) / 2)


def measured_box(
    cloud: NDArray[np.floating], box: UprightBox, yaw: float, camera: ArrayLike, trim: float
) -> UprightBox:
    """The object's box along axes turned by `yaw`, its heights those of `box`, which reaches down to the support.

    Args:
        cloud: (N, 3) in the floor frame.
        box: the minimum box that extraction found.
        camera: its position, floor frame.
        trim: share of the points left out at an end.
    """
    turn = yaw_matrix(yaw)[:2, :2]
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    to_camera = (np.asarray(camera, dtype=float)[:2] - center[:2]) @ turn
    points = np.asarray(cloud, dtype=float)[:, :2] @ turn
    limits = np.quantile(points, [trim, 1 - trim], axis=0)
    reach = noise_reach(float(np.linalg.norm(to_camera)))
    for axis in (0, 1):
        end = 1 if to_camera[axis] > 0 else 0
        limits[end, axis] = near_end(points[:, axis], 2 * end - 1, reach, trim)
    center[:2] = turn @ limits.mean(axis=0)
    size[:2] = limits[1] - limits[0]
    return UprightBox(center, size, yaw)
