"""The box of an object from the noisy cloud that a depth camera has of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d

from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

TRIM = 0.005  # share of an exact cloud's points left out at either end of an extent; half of A.7's; chosen
BIN = 0.005  # metres: width of a bin of coordinates; chosen
SPREAD = 0.015  # metres by which points of a face spread without noise (panels, handles); chosen
REACH = 3.0  # standard deviations of noise: 99.7 % of the points of a face lie within
PROMINENT = 2.0  # times the mean density of points, from which on there is a face; chosen
FAINT = 0.05  # metres of noise, from which on it may hide a whole object; chosen
SLICES = 6  # parts of the depth of a top, all of which must be seen; chosen
END_SHIFT = 0.7  # standard deviations by which noise moves an end that is no face; chosen
MAX_INSET = 0.25  # share of the length that is taken off there at most; chosen
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

    @cached_property
    def ray(self) -> Array:
        """Unit vector (3,) from the camera to the middle of the points."""
        ray = self.points.mean(axis=0) - self.camera
        return np.asarray(ray / np.linalg.norm(ray))

    @cached_property
    def noise(self) -> float:
        """Standard deviation, metres, of the points along the ray, caused by depth noise."""
        return self.error(float(np.linalg.norm(self.points.mean(axis=0) - self.camera)))

    def measure_ends(self, yaw: float, trim: float, deviations: float) -> Array:
        """Lowest and highest level coordinates (2, 2) of the points along axes turned by `yaw`.

        Noise puts points outside the faces, so `deviations` standard deviations are taken off at both ends.

        Args:
            trim: share of the points left out at each end.
        """
        limits = np.quantile(self.points[:, :2] @ yaw_matrix(yaw)[:2, :2], [trim, 1 - trim], axis=0)
        inset = np.minimum(deviations * self.noise_along(yaw), MAX_INSET * (limits[1] - limits[0]))
        return np.stack([limits[0] + inset, limits[1] - inset])

    def noise_along(self, yaw: float) -> Array:
        """Standard deviation (2,), metres, of noise along the level axes turned by `yaw`."""
        return np.abs(self.ray[:2] @ yaw_matrix(yaw)[:2, :2]) * self.noise

    def measure_box(
        self, box: UprightBox, yaw: float, trim: float, has_faces: bool = True, beyond: float = 0.0
    ) -> UprightBox:
        """The object's box along axes turned by `yaw`, its heights those of `box`, which reaches down to the support.

        Args:
            box: the minimum box of its points.
            trim: share of the points left out at each end.
            has_faces: False for round things: their near end is the end of the points.
            beyond: metres by which handles and the like of its model protrude from the front face (+x).
        """
        turn = yaw_matrix(yaw)[:2, :2]
        center, size = box.center.copy(), box.size.copy()
        level, limits = self.points[:, :2] @ turn, self.measure_ends(yaw, trim, END_SHIFT)
        for axis, along in enumerate(self.ray[:2] @ turn):
            near = 1 if along < 0 else 0
            face = (
                find_near_face(level[:, axis], 2 * near - 1, self.noise_along(yaw)[axis], trim) if has_faces else None
            )
            if face is not None:
                limits[near, axis] = face + (beyond if axis == 0 and near == 1 else 0.0)
        limits.sort(axis=0)
        center[:2] = turn @ limits.mean(axis=0)
        size[:2] = limits[1] - limits[0]
        return UprightBox(center, size, yaw)

    def is_one_face(self, normal: Array) -> bool:
        """Whether the points spread no wider along a direction (3,) than noise spreads a single face."""
        noise = abs(float(self.ray @ normal)) * self.noise
        low, high = np.quantile(self.points @ normal, [0.05, 0.95])
        return bool(noise > FAINT and high - low < 2 * REACH * noise)

    def sees_top(self, box: UprightBox) -> bool:
        """Whether the top of the object with this box is seen from front to rear, so that its depth is measured."""
        size = box.size
        if box.top > self.camera[2]:
            return False
        turn = yaw_matrix(box.yaw)
        local = (self.points - box.center) @ turn
        axis = int(np.argmax(np.abs(self.ray[:2] @ turn[:2, :2])))
        on_top = local[local[:, 2] > size[2] / 2 - max(SPREAD, REACH * self.noise), axis]
        if size[axis] < 2 * REACH * self.noise or len(on_top) < 10 * SLICES:
            return False
        counts, _ = np.histogram(on_top, SLICES, (-size[axis] / 2, size[axis] / 2))
        return bool(counts.all())


def find_near_face(values: Array, sign: float, noise: float, trim: float) -> float | None:
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
    density = gaussian_filter1d(counts.astype(float), max(SPREAD, noise / 2) / BIN, mode="constant")
    outer = density[: max(1, min(bins // 2, int(max(SPREAD, REACH * noise) / BIN)))]
    peak = int(np.argmax(outer))
    if outer[peak] < PROMINENT * len(values) / bins:
        return None
    return float(-sign * (edges[peak] + edges[peak + 1]) / 2)


def correct_depth(
    box: UprightBox, native: ArrayLike, fixed_face: ArrayLike, believable: tuple[float, float]
) -> UprightBox:
    """The box with its depth replaced if it cannot be that of such a model.

    The scale of an axis is its extent over the model's native one. The median of the three scales is
    the model's scale; a depth whose scale is outside `believable` times it gets that scale. Width and
    height are left alone: the picture shows them.

    Args:
        box: measured extents along the model's axes.
        native: extents (3,) of the model as it is in the library.
        fixed_face: direction (2,) to the face that stays where it is: towards the camera, since that
            side was seen, or towards the wall that the object touches. Depth is along it.
    """
    size, native = box.size.copy(), np.asarray(native, dtype=float)
    along = yaw_matrix(box.yaw)[:2, :2].T @ np.asarray(fixed_face, dtype=float)[:2]
    depth = int(np.argmax(np.abs(along)))
    scales = size / native
    scale = float(np.median(scales))
    if believable[0] * scale <= scales[depth] <= believable[1] * scale:
        return box
    growth = scale * native[depth] - size[depth]
    size[depth] += growth
    center = box.center - np.sign(along[depth]) * growth / 2 * yaw_matrix(box.yaw)[:, depth]
    return replace(box, center=center, size=size)
