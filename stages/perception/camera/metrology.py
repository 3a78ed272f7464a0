"""Single-view metrology (Criminisi, Reid, Zisserman 2000): from pixels to points, walls and boxes of a room.

The room frame: z = 0 on the floor and up, origin below the camera, x along the walls to the right, y along the
walls and away from the camera. All lengths scale with the height of the camera; pixel centers are at integers.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import make_intrinsics, make_transform

Points = NDArray[np.float64]
HORIZON = 60.0  # heights of the camera: a floor point farther away lies at the horizon and says nothing
CLICK = 3.0  # pixels by which a point that was marked may be off
DRAWING_ERROR = 0.002  # metres: less is an error of drawing
FLAT_DEPTH = 0.03  # metres: depth of something on a wall whose kind is unknown


class MetrologyError(Exception):
    """The marks fit nothing in space; the message says why, for the person who drew them."""


class RearCornerError(MetrologyError):
    """The pixel of a rear corner fits nothing in space; the other pixels of the box do."""


@dataclass(frozen=True)
class PinholeView:
    """A pinhole camera over the floor: focal length in pixels, room_from_camera rotation, height in metres."""

    width: int
    height: int
    focal: float
    rotation: Points
    above: float = 1.0

    @property
    def intrinsics(self) -> Points:
        """3x3 matrix K: square pixels, principal point in the center."""
        return make_intrinsics(self.focal, self.focal, *self.center)

    @property
    def center(self) -> tuple[float, float]:
        """The pixel of the optical axis."""
        return (self.width - 1) / 2, (self.height - 1) / 2

    @property
    def room_from_camera(self) -> Points:
        """Rigid 4x4 transform."""
        return make_transform(self.rotation, [0.0, 0.0, self.above])

    def rays(self, pixels: ArrayLike) -> Points:
        """Directions (..., 3) in the room frame through pixels (..., 2); depth along the optical axis is 1."""
        given = np.asarray(pixels, dtype=float)
        flat = np.concatenate([(given - self.center) / self.focal, np.ones_like(given[..., :1])], axis=-1)
        return np.asarray(flat @ self.rotation.T)

    def project(self, points: ArrayLike) -> Points:
        """Pixels (..., 2) of points (..., 3) of the room frame; NaN behind the camera."""
        local = (np.asarray(points, dtype=float) - [0, 0, self.above]) @ self.rotation
        depth = np.where(local[..., 2:] > 1e-3 * self.above, local[..., 2:], np.nan)
        return np.asarray(local[..., :2] / depth * self.focal + self.center)

    def meet_level(self, pixel: ArrayLike, z: float = 0.0) -> Points:
        """The point (3,) at height z that a pixel shows.

        Raises:
            MetrologyError: the ray does not come down (or up) to that height.
        """
        ray = self.rays(pixel)
        reach = (z - self.above) / ray[2] if ray[2] else np.inf
        if not 0 < reach < HORIZON * self.above:
            where = "above" if z < self.above else "below"
            raise MetrologyError(f"a point of it lies {where} the horizon, where its ground cannot be seen")
        return np.asarray(ray * reach + [0, 0, self.above])

    def meet_plane(self, pixel: ArrayLike, normal: ArrayLike, offset: float) -> Points:
        """The point (3,) of the upright plane `normal . p = offset` that a pixel shows."""
        ray = self.rays(pixel)
        towards = ray @ np.asarray(normal)
        reach = offset / towards if abs(towards) > 1e-9 else np.inf
        if not 0 < reach < HORIZON * self.above:
            raise MetrologyError("a point of it does not lie on that wall")
        return np.asarray(ray * reach + [0, 0, self.above])


@dataclass(frozen=True)
class UprightPlane:
    """An upright plane: normal . p = offset, the normal (3,) horizontal and towards the camera, so offset < 0."""

    normal: Points
    offset: float
    ends: tuple[float, float] = (-np.inf, np.inf)  # along it: where other walls cut it off

    @property
    def along(self) -> Points:
        """Its level direction (3,)."""
        return np.array([-self.normal[1], self.normal[0], 0.0])

    def reach(self, rays: ArrayLike) -> Points:
        """Depth (...) at which rays (..., 3) from the camera hit its front; inf: they miss it."""
        towards, sideways = np.asarray(rays) @ self.normal, np.asarray(rays) @ self.along
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where(towards < 0, self.offset / towards, np.inf)
            at = reach * sideways
        low, high = self.ends
        return np.where((at >= low - DRAWING_ERROR) & (at <= high + DRAWING_ERROR), reach, np.inf)


def snap_direction(direction: Points, free: bool) -> Points:
    """The horizontal direction (3,) as a unit vector, laid along the nearest axis of the room unless it is `free`."""
    flat = np.array([direction[0], direction[1], 0.0])
    length = float(np.linalg.norm(flat))
    if length < 1e-9:
        raise MetrologyError("its two ends are the same point")
    if free:
        return flat / length
    axis = int(np.argmax(np.abs(flat)))
    unit = np.zeros(3)
    unit[axis] = np.sign(flat[axis])
    return unit


def wall_plane(view: PinholeView, a: ArrayLike, b: ArrayLike, free: bool) -> UprightPlane:
    """The wall over a line on the floor, given by two pixels."""
    start, end = view.meet_level(a), view.meet_level(b)
    along = snap_direction(end - start, free)
    normal = np.array([-along[1], along[0], 0.0])
    offset = float((start + end) @ normal / 2)
    if offset > 0:
        normal, offset = -normal, -offset
    if offset > -1e-6:
        raise MetrologyError("the wall would go through the camera")
    return UprightPlane(normal, offset)


def depth_by_pixel(view: PinholeView, corners: Points, inward: Points, pixel: ArrayLike) -> float:
    """How far the front's corners (N, 3) go back along `inward` (3,) if a pixel shows one of the rear corners.

    Every corner says how deep it would be; the one whose edge passes nearest to the pixel is right. Edges above each
    other fall together in the picture if we look along their face: then the lesser depth is.
    """
    ray = view.rays(pixel)
    ray = ray / np.linalg.norm(ray)
    across = ray - (ray @ inward) * inward
    if np.linalg.norm(across) < 1e-9:
        raise RearCornerError("its rear corner lies where its edges vanish")
    from_eye = np.array([0, 0, view.above]) - corners
    depths = (from_eye - (from_eye @ ray)[:, None] * ray) @ inward / (1 - (ray @ inward) ** 2)
    pixels = view.project(corners + np.maximum(depths, 0)[:, None] * inward)
    misses = np.linalg.norm(pixels - np.asarray(pixel, dtype=float), axis=1)
    misses = np.where(np.isfinite(misses), misses, np.inf)
    best = int(np.argmin(misses))
    if depths[best] <= 0:
        raise RearCornerError("its rear corner lies before its front")
    rivals = (misses < misses[best] + CLICK) & (depths > 0) & (depths < depths[best] / 2)
    return float(depths[rivals].min() if rivals.any() else depths[best])


def _box(front: Points, inward: Points, size: tuple[float, float, float], bottom: float) -> UprightBox:
    """The box behind a front: `front` is any point under the front's middle, size is (width, depth, height)."""
    width, depth, height = size
    middle = [*(front + inward * depth / 2)[:2], bottom + height / 2]
    return UprightBox(middle, [width, depth, height], float(np.arctan2(-inward[0], inward[1])))


def fit_standing_box(
    view: PinholeView,
    ground: float,
    pixels: list[tuple[float, float]],
    sizes: tuple[float | None, float | None, float | None],
    free: bool,
    deep: float | None = None,
) -> UprightBox:
    """A box on a level ground: the two lower corners of its front, a point of the front's upper edge, a rear corner.

    The box's x axis is its width, from left to right; y goes back. What is missing is guessed.

    Args:
        ground: height of what it stands on.
        pixels: two to four; without the third it is flat, without the fourth its depth is guessed.
        sizes: width, depth and height in metres where they are known; the front's middle stays.
        free: its front need not run along a wall.
        deep: metres that are guessed; None: as deep as it is wide, 0.6 m at most.
    """
    left, right = view.meet_level(pixels[0], ground), view.meet_level(pixels[1], ground)
    along = snap_direction(right - left, free)
    middle = (left + right) / 2
    inward = np.array([-along[1], along[0], 0.0])
    if inward @ middle < 0:
        inward = -inward
    width = sizes[0] or max(abs(float((right - left) @ along)), 1e-4 * view.above)
    height = sizes[2] or 1e-4 * view.above
    if sizes[2] is None and len(pixels) > 2:
        height = float(view.meet_plane(pixels[2], inward, float(inward @ middle))[2]) - ground
        if height <= 0:
            raise MetrologyError("its top lies below its base")
    depth = sizes[1] or deep or min(width, 0.6)
    if sizes[1] is None and len(pixels) > 3:
        ends = [middle - along * width / 2, middle + along * width / 2]
        corners = np.array([[*end[:2], z] for end in ends for z in (ground, ground + height)])
        depth = depth_by_pixel(view, corners, inward, pixels[3])
    return _box(middle, inward, (width, depth, height), ground)


def round_box(
    view: PinholeView,
    ground: float,
    pixels: list[tuple[float, float]],
    sizes: tuple[float | None, float | None, float | None],
) -> UprightBox:
    """The box around a round thing, from the left and right end of its base, level with its center, and its top.

    Args:
        pixels: two or three; without the third it is flat. If that lies farther to a side than its base does, its top
            ends there.
        sizes: width, depth and height in metres where they are known; its center stays.
    """
    left, right = view.meet_level(pixels[0], ground), view.meet_level(pixels[1], ground)
    middle = (left + right) / 2
    width = sizes[0] or max(float(np.linalg.norm(right - left)), 1e-4 * view.above)
    height = sizes[2] or 1e-4 * view.above
    if len(pixels) > 2 and None in (sizes[0], sizes[2]):
        away = middle * [1, 1, 0] / np.linalg.norm(middle[:2])
        top = view.meet_plane(pixels[2], away, float(away @ middle))
        width = sizes[0] or max(width, 2 * float(np.linalg.norm((top - middle)[:2])))
        height = sizes[2] or float(top[2]) - ground
        if height <= 0:
            raise MetrologyError("its top lies below its base")
    return UprightBox([*middle[:2], ground + height / 2], [width, sizes[1] or width, height], 0.0)


def _face(view: PinholeView, wall: UprightPlane, depth: float, pixels: list[tuple[float, float]]) -> Points:
    """Two opposite corners (2, 3) of a face parallel to a wall, `depth` before it."""
    return np.array([view.meet_plane(pixel, wall.normal, wall.offset + depth) for pixel in pixels[:2]])


def _depth_of_rear(view: PinholeView, wall: UprightPlane, pixels: list[tuple[float, float]]) -> float:
    """How far a face stands out from a wall if the third of the pixels shows a rear corner, on the wall.

    A corner of the face moves along its ray with the depth, linearly; that depth is right at which one of the four
    corners comes nearest to the rear corner (least squares).
    """
    rear = view.meet_plane(pixels[2], wall.normal, wall.offset)
    near, far = (_face(view, wall, depth, pixels) for depth in (-wall.offset / 2, 0.0))
    plan = np.stack([wall.along, [0.0, 0.0, 1.0]])
    starts = np.array([(far[i] @ plan[0], far[j] @ plan[1]) for i in (0, 1) for j in (0, 1)])
    ends = np.array([(near[i] @ plan[0], near[j] @ plan[1]) for i in (0, 1) for j in (0, 1)])
    steps, gaps = (ends - starts) * 2 / -wall.offset, plan @ rear - starts
    depths = (steps * gaps).sum(axis=1) / (steps**2).sum(axis=1)
    misses = np.linalg.norm(gaps - depths[:, None] * steps, axis=1)
    depth = float(depths[np.argmin(np.where(depths > 0, misses, np.inf))])
    if not 0 < depth < -wall.offset:
        raise RearCornerError("its rear corner does not lie behind its front")
    return depth


def fit_hanging_box(
    view: PinholeView,
    wall: UprightPlane,
    pixels: list[tuple[float, float]],
    sizes: tuple[float | None, float | None, float | None],
    flat: float = 0.03,
) -> UprightBox:
    """A box on a wall, from two opposite corners of its front and one rear corner, which lies on the wall.

    Args:
        pixels: two or three.
        sizes: width, depth and height in metres where they are known; the front's middle stays.
        flat: its depth without a third pixel.
    """
    depth = sizes[1] or flat
    if sizes[1] is None and len(pixels) > 2:
        depth = _depth_of_rear(view, wall, pixels)
    face = _face(view, wall, depth, pixels)
    (left, right), (low, high) = np.sort(face @ wall.along), np.sort(face[:, 2])
    width, height = sizes[0] or max(right - left, 1e-4), sizes[2] or max(high - low, 1e-4)
    return hang_box(wall, (left + right) / 2, (low + high) / 2, (width, depth, height))


def hang_box(wall: UprightPlane, along: float, above: float, size: tuple[float, float, float]) -> UprightBox:
    """The box with its rear on a wall, its middle so far along that and above the floor; width, depth and height."""
    return _box(along * wall.along + (wall.offset + size[1]) * wall.normal, -wall.normal, size, above - size[2] / 2)
