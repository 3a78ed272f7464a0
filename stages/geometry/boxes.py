"""Upright boxes: corners, footprint, intersection over union (paper B.1)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from shapely import Polygon

from roomkin.stages.geometry.frames import yaw_matrix

THINNEST = 0.01  # metres: no thing is thinner, and heights that differ by less are one (noise of depth); chosen
# Corners of the faces +x, +y, -x, -y of a box (lower left, lower right, upper right, upper left), of its top and foot.
FACES = ((1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (0, 1, 5, 4), (4, 5, 6, 7), (0, 1, 2, 3))
_SIGNS = np.array([(x, y, z) for z in (-0.5, 0.5) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))])


@dataclass(frozen=True, init=False, eq=False)
class UprightBox:
    """A box turned about z: center (3,), extents (3,) along its own axes, yaw in radians. Its arrays are read-only."""

    center: NDArray[np.float64]
    size: NDArray[np.float64]
    yaw: float

    def __init__(self, center: ArrayLike, size: ArrayLike, yaw: float) -> None:
        for name, value in (("center", center), ("size", size)):
            array = np.array(value, dtype=float)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "yaw", yaw)

    @property
    def bottom(self) -> float:
        """Height of the lower face."""
        return float(self.center[2] - self.size[2] / 2)

    @property
    def top(self) -> float:
        """Height of the upper face."""
        return float(self.center[2] + self.size[2] / 2)


def corners(box: UprightBox) -> NDArray[np.float64]:
    """The 8 corners (8, 3): bottom face counter-clockwise from (-x, -y), then the top face."""
    return _SIGNS * box.size @ yaw_matrix(box.yaw).T + box.center


def depth_behind(box: UprightBox, normal: ArrayLike, offset: float) -> float:
    """How far a box reaches behind the plane `normal . x = offset`, metres; negative: the box is in front of it."""
    return offset - float((corners(box) @ np.asarray(normal)).min())


def is_behind(box: UprightBox, normal: ArrayLike, offset: float) -> bool:
    """Whether a box lies wholly behind a wall plane. If the camera sees it, the wall has an opening or an end there."""
    return float((corners(box) @ np.asarray(normal)).max()) < offset


def footprint(box: UprightBox) -> Polygon:
    """The box seen from above, as a polygon in the x-y plane."""
    return Polygon(corners(box)[:4, :2])


def bounds(box: UprightBox) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest corner (3,), (3,) of the axis-aligned box around the box."""
    points = corners(box)
    return points.min(axis=0), points.max(axis=0)


def with_top(box: UprightBox, top: float) -> UprightBox:
    """The box with its top face moved to height `top`, its bottom face kept below that."""
    return _cut_between(box, min(box.bottom, top - THINNEST), top)


def with_bottom(box: UprightBox, bottom: float) -> UprightBox:
    """The box with its bottom face moved to height `bottom`."""
    return _cut_between(box, bottom, box.top)


def _cut_between(box: UprightBox, bottom: float, top: float) -> UprightBox:
    return UprightBox([*box.center[:2], (top + bottom) / 2], [*box.size[:2], top - bottom], box.yaw)


def surface_points(box: UprightBox, count: int) -> NDArray[np.float64]:
    """About `count` points (N, 3) spread evenly over all six faces."""
    size = box.size
    step = np.sqrt(2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]) / count)
    counts = np.maximum(2, np.rint(size / step).astype(int))
    axes = [np.linspace(-length / 2, length / 2, n) for length, n in zip(size, counts, strict=True)]
    grid = np.stack([values.ravel() for values in np.meshgrid(*axes, indexing="ij")], axis=1)
    local = grid[(np.abs(grid) >= size / 2 * (1 - 1e-9)).any(axis=1)]
    return np.asarray(local @ yaw_matrix(box.yaw).T + box.center)


def round_off_box(points: NDArray[np.float64], box: UprightBox) -> NDArray[np.float64]:
    """Move points (N, 3) of a box towards its vertical axis, into the elliptic cylinder inscribed in it."""
    turn, half = yaw_matrix(box.yaw), box.size[:2] / 2
    local = (points - box.center) @ turn
    plan = local[:, :2] / half
    far = np.linalg.norm(plan, axis=1)
    local[:, :2] *= (np.abs(plan).max(axis=1) / np.maximum(far, 1e-9))[:, None]
    return np.asarray(local @ turn.T + box.center)


def volume(box: UprightBox) -> float:
    """Volume in cubic metres."""
    return float(np.prod(box.size))


def axis_aligned_iou(a: UprightBox, b: UprightBox) -> float:
    """Intersection over union in [0, 1] of the axis-aligned boxes around two boxes ("Bbox IoU", Table 2)."""
    (low_a, high_a), (low_b, high_b) = bounds(a), bounds(b)
    overlap = np.prod(np.clip(np.minimum(high_a, high_b) - np.maximum(low_a, low_b), 0, None))
    union = np.prod(high_a - low_a) + np.prod(high_b - low_b) - overlap
    return float(overlap / union) if union > 0 else 0.0


def oriented_iou(a: UprightBox, b: UprightBox) -> float:
    """Intersection over union in [0, 1] of two boxes with their yaws ("Ori. Bbox IoU", Table 2)."""
    (low_a, high_a), (low_b, high_b) = bounds(a), bounds(b)
    height = max(0.0, min(high_a[2], high_b[2]) - max(low_a[2], low_b[2]))
    overlap = footprint(a).intersection(footprint(b)).area * height
    union = volume(a) + volume(b) - overlap
    return float(overlap / union) if union > 0 else 0.0


def distances_along(origin: NDArray[np.float64], rays: NDArray[np.float64], box: UprightBox) -> NDArray[np.float64]:
    """Distances (...) along rays (..., 3) from `origin` (3,) to a box, in lengths of the ray; inf: it misses."""
    turn = yaw_matrix(box.yaw)
    start, along, half = (origin - box.center) @ turn, rays @ turn, box.size / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (-half - start) / along, (half - start) / along
    enter, leave = np.fmin(one, other).max(axis=-1), np.fmax(one, other).min(axis=-1)
    return np.where((enter < leave) & (enter > 0), enter, np.inf)


def front_corners(box: UprightBox, facing: float) -> NDArray[np.float64]:
    """Corners (4, 3) of the side that looks most along a direction about z: lower left, lower right, upper right and
    upper left as whoever faces it sees them."""
    ahead, aside = np.cos(facing - box.yaw), np.sin(facing - box.yaw)
    return corners(box)[list(FACES[int(np.argmax([ahead, aside, -ahead, -aside]))])]


def extents(points: NDArray[np.float64]) -> tuple[float, float]:
    """Width and height between corners (4, D)."""
    return float(np.linalg.norm(points[1] - points[0])), float(np.linalg.norm(points[3] - points[0]))
