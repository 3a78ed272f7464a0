"""The given side of every comparison: an object on a small grid of rays, its ends, and how it may stand."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.objects import DepthError, SceneObject, Wall
from roomkin.stages.geometry.frames import FloorCamera, back_project, transform_points, wrap_angle, yaw_matrix
from roomkin.stages.geometry.masks import OUTLINE, ObjectView, pixel_bounds
from roomkin.stages.geometry.robust import REACH

SAMPLES = 2  # rays per cell and direction: thin lines do not break; chosen
SURROUNDINGS = 0.12  # of the object's longer side, around its mask; chosen
EDGE_SHARE = 0.03  # of its extent: the pixels that make up a side of the mask; chosen
CLOUD_POINTS = 6000  # at most about twice so many; chosen for time
NEARER = 0.05  # metres, beyond the noise of depth; chosen
Array = NDArray[np.float64]


@dataclass(frozen=True)
class ObservedGrid(FloorCamera):
    """The object on a grid (h, w) of cells, each `step` pixels wide.

    rgb (h, w, 3) 0 to 1; mask: its pixels; depth: metres along the optical axis, 0: unknown, of all that is seen;
    depth_error: of that; inside: cells in the picture; corner: pixel (x, y) where the first cell begins; sides: left,
    top, right, bottom of the mask in pixels of the picture; free: which of these are the object's own, neither hidden
    nor cut off; cloud: its points (N, 3), floor frame.
    """

    rgb: NDArray[np.float32]
    mask: NDArray[np.bool_]
    depth: NDArray[np.float32]
    depth_error: DepthError
    inside: NDArray[np.bool_]
    corner: Array
    step: float
    sides: Array
    free: NDArray[np.bool_]
    cloud: Array

    @cached_property
    def rays(self) -> Array:
        """Directions (h * SAMPLES, w * SAMPLES, 3) in the floor frame, 1 along the optical axis."""
        h, w = self.mask.shape
        x, y = (
            low + (np.arange(count * SAMPLES) + 0.5) / SAMPLES * self.step - 0.5
            for low, count in zip(self.corner, (w, h), strict=True)
        )
        pixels = np.stack([*np.meshgrid(x, y), np.ones((len(y), len(x)))], axis=-1)
        return pixels @ np.linalg.inv(self.intrinsics).T @ self.floor_from_camera[:3, :3].T

    def find_hidden(self, depth: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Cells (h, w) where something else lies in front of `depth` (h, w), or the picture ends."""
        in_front = (self.depth > 0) & (depth - self.depth > measure_occluder_gap(depth, self.depth_error)) & ~self.mask
        return ~self.inside | in_front


def measure_occluder_gap(depth: NDArray[np.floating], error: DepthError) -> NDArray[np.floating]:
    """Metres by which what hides a thing is nearer; less may be noise of depth, or the floor that it stands on."""
    return NEARER + REACH * error.predict(depth)


def observe(view: ObjectView, floor_from_camera: Array, depth_error: DepthError, longest: int) -> ObservedGrid:
    """The object and a little of what is around it, at most `longest` cells across; no cell is less than a pixel.

    The view has depth and intrinsics, and its mask is not empty.
    """
    assert view.depth is not None and view.intrinsics is not None
    x0, y0, x1, y1 = pixel_bounds(view.mask)
    around = int(np.ceil(SURROUNDINGS * max(x1 - x0, y1 - y0))) + 2
    width, height = x1 - x0 + 2 * around, y1 - y0 + 2 * around
    step = max(1.0, max(width, height) / longest)
    w, h = int(np.ceil(width / step)), int(np.ceil(height / step))
    corner = np.array([(x0 + x1 - w * step) / 2, (y0 + y1 - h * step) / 2])
    x, y = (low + (np.arange(n) + 0.5) * step - 0.5 for low, n in zip(corner, (w, h), strict=True))
    across, down = np.meshgrid(x.astype(np.float32), y.astype(np.float32))

    def smooth(values: NDArray[np.float32]) -> NDArray[np.float32]:
        blurred = cv2.GaussianBlur(values, (0, 0), 0.35 * step) if step > 1 else values
        cells = cv2.remap(blurred, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(cells, np.float32)

    rows, columns = view.mask.shape
    inside = ((y > -0.5) & (y < rows - 0.5))[:, None] & ((x > -0.5) & (x < columns - 0.5))
    nearest = np.ix_(np.rint(y).astype(int).clip(0, rows - 1), np.rint(x).astype(int).clip(0, columns - 1))
    return ObservedGrid(
        rgb=smooth(view.rgb.astype(np.float32) / np.float32(255)),
        mask=(smooth(view.mask.astype(np.float32)) >= 0.5) & inside,
        depth=np.where(inside, view.depth[nearest], 0).astype(np.float32),
        depth_error=depth_error, inside=inside, corner=corner, step=step,
        intrinsics=np.asarray(view.intrinsics, dtype=float),
        floor_from_camera=np.asarray(floor_from_camera, dtype=float), sides=np.array([x0, y0, x1, y1]) - 0.5,
        free=free_sides(view.mask, view.depth, depth_error), cloud=_cloud(view, floor_from_camera),
    )  # fmt: skip


def _cloud(view: ObjectView, floor_from_camera: Array) -> Array:
    """Points (N, 3) of the object, floor frame; its outermost pixels, half of them background, only if all are."""
    assert view.depth is not None and view.intrinsics is not None
    known = view.mask & (view.depth > 0)
    inner = cv2.erode(view.mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    chosen = known & inner if (known & inner).any() else known
    points = transform_points(floor_from_camera, back_project(view.depth, view.intrinsics)[chosen])
    return points[:: max(1, len(points) // CLOUD_POINTS)]


def free_sides(mask: NDArray[np.bool_], depth: NDArray[np.floating], error: DepthError) -> NDArray[np.bool_]:
    """Which of left, top, right, bottom of a mask are the object's own: not at the picture's border, nothing nearer
    beyond."""
    free = []
    for turns in range(4):  # quarter turns bring left, top, right, bottom to the left
        turned, distance = np.rot90(mask, turns), np.rot90(depth, turns)
        columns = np.flatnonzero(turned.any(axis=0))
        first, band = int(columns[0]), max(2, round(EDGE_SHARE * len(columns)))
        if first < OUTLINE:
            free.append(False)
            continue
        rows, at = np.nonzero(turned[:, first : first + band])
        own, other = distance[rows, at + first], distance[rows, first - OUTLINE]
        known = (own > 0) & (other > 0)
        hidden = own[known] - other[known] > measure_occluder_gap(own[known], error)
        free.append(not hidden.size or bool(hidden.mean() < 0.5))
    return np.array(free)


MAX_INSET = 0.25  # share of the length that is taken off an end at most; chosen


@dataclass(frozen=True)
class NoisyCloud:
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


def touched_walls(item: SceneObject, scene: Objects) -> list[Wall]:
    """The walls that an object touches, the dominant one first."""
    names = item.mounting.walls if item.mounting is not None and item.mounting.type != 2 else []
    walls = {wall.id: wall for wall in scene.walls}
    return [walls[name] for name in names]


def is_front_known(item: SceneObject, scene: Objects) -> bool:
    """Whether the input tells its front, or a wall is at its rear: no picture needs to say which way it faces."""
    return item.front is not None or bool(touched_walls(item, scene))


def aligned_yaws(item: SceneObject, scene: Objects) -> list[float]:
    """Yaws, floor frame: its front's if the input tells it; else away from each wall that it touches, the dominant one
    first, as generation lays rears into walls (paper A.3); else the four along its box."""
    assert item.box is not None
    if item.front is not None:
        return [item.front]
    walls = touched_walls(item, scene)
    if walls:
        return [float(np.arctan2(wall.normal[1], wall.normal[0])) for wall in walls]
    return [wrap_angle(item.box.yaw + quarter) for quarter in np.arange(4) * np.pi / 2]
