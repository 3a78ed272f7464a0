"""The box of an object from the noisy cloud that a depth camera has of it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

BIN, SMOOTHING = 0.005, 0.015  # metres; densities are smoothed by half the noise as well
PROMINENT = 2.0  # a face is where points lie so many times denser than on average
NEAR, REACH = 0.015, 3.0  # metres, standard deviations: how far the outermost points may lie before their face
FAINT, THICK = 0.05, 4.5  # metres of noise; standard deviations in which nine of ten points of a face lie, and some
STEEP = 0.35  # sine of the least angle from which a top is seen
LEVEL, SLICES, FILLED = 0.12, 6, 0.3  # share of the height that is the top; parts of its depth; least share in each
MEASURED = 6.0  # standard deviations: what is no deeper is noise
OUTSIDE, MOST = 0.7, 0.25  # standard deviations by which noise moves an end that is no face; share of the length
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sight:
    """An object as a depth camera sees it.

    points: (N, 3). camera: its position (3,), in the same frame, z up. error: the standard deviation of depth, metres,
    at a distance from the camera, metres.
    """

    points: Array
    camera: Array
    error: Callable[[float], float]

    def measured(
        self, box: UprightBox, yaw: float, trim: float, has_faces: bool = True, beyond: float = 0.0
    ) -> UprightBox:
        """The object's box along axes turned by `yaw`, its heights those of `box`, which reaches down to the support.

        Args:
            box: the minimum box of its points.
            trim: share of the points left out at an end.
            has_faces: what is round has none, and its near end is where its points end.
            beyond: metres by which the model that stands for it reaches beyond the face that it shows towards +x.
        """
        turn = yaw_matrix(yaw)[:2, :2]
        center, size = box.center.copy(), box.size.copy()
        level = self.points[:, :2] @ turn
        limits = np.quantile(level, [trim, 1 - trim], axis=0)
        ray = box.center - self.camera
        distance = float(np.linalg.norm(ray))
        for axis, along in enumerate((ray[:2] @ turn) / distance):
            noise = abs(along) * self.error(distance)
            inset = min(OUTSIDE * noise, MOST * float(np.ptp(limits[:, axis])))
            limits[:, axis] += [inset, -inset]
            near = 1 if along < 0 else 0
            face = near_face(level[:, axis], 2 * near - 1, noise, trim) if has_faces else None
            if face is not None:
                limits[near, axis] = face + (beyond if axis == 0 and near == 1 else 0.0)
        limits.sort(axis=0)
        center[:2] = turn @ limits.mean(axis=0)
        size[:2] = limits[1] - limits[0]
        return UprightBox(center, size, yaw)

    def is_one_face(self, normal: Array) -> bool:
        """Whether the points are no thicker along a direction (3,) than one face far away is made by noise."""
        ray = np.mean(self.points, axis=0) - self.camera
        distance = float(np.linalg.norm(ray))
        noise = abs(float(ray @ normal)) / distance * self.error(distance)
        low, high = np.quantile(self.points @ normal, [0.05, 0.95])
        return bool(noise > FAINT and high - low < THICK * noise)

    def sees_top(self, box: UprightBox) -> bool:
        """Whether the top of the object, whose box is `box`, is seen from its front edge to its rear one.

        Its depth is then measured.
        """
        ray, size = box.center - self.camera, box.size
        distance = float(np.linalg.norm(ray))
        if ray[2] + size[2] / 2 > -STEEP * distance:
            return False
        noise = self.error(distance)
        local = (self.points - box.center) @ yaw_matrix(box.yaw)
        axis = int(np.argmax(np.abs(ray[:2] @ yaw_matrix(box.yaw)[:2, :2])))
        on_top = local[local[:, 2] > size[2] / 2 - max(LEVEL * size[2], 2 * noise), axis]
        if size[axis] < MEASURED * noise or len(on_top) < 10 * SLICES:
            return False
        counts, _ = np.histogram(on_top, SLICES, (-size[axis] / 2, size[axis] / 2))
        return bool(counts.min() > FILLED * counts.mean())


def near_face(values: Array, sign: float, noise: float, trim: float) -> float | None:
    """Where the face is on the side `sign` (1: high, -1: low) of an axis; None if the points have none there.

    Many points lie at one coordinate, spread by the noise of depth, and the outermost ones are two or three
    standard deviations in front of it. A face is where the points are densest, not far behind their end.

    Args:
        values: (N,) coordinates.
        noise: standard deviation of their noise, metres.
        trim: share of the points left out before their end.
    """
    inward = -sign * values  # grows into the object
    low, high = np.quantile(inward, [trim, 1 - trim])
    bins = int((high - low) / BIN)
    if bins < 2:
        return None
    counts, edges = np.histogram(inward, bins, (low, high))
    density = gaussian_filter1d(counts.astype(float), max(SMOOTHING, noise / 2) / BIN, mode="constant")
    outer = density[: max(1, min(bins // 2, int(max(NEAR, REACH * noise) / BIN)))]
    peak = int(np.argmax(outer))
    if outer[peak] < PROMINENT * len(values) / bins:
        return None
    return float(-sign * (edges[peak] + edges[peak + 1]) / 2)
