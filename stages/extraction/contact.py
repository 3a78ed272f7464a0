"""Contacts of an object, by what the picture shows of the space between: walls, surfaces below it (paper A.2).

A single picture shows one side of an object. A gap between it and a wall counts only if the camera sees into it;
hidden space is taken to be filled by the object.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roomkin.stages.contracts.objects import USUAL_ERROR, DepthError, Mounting, Wall
from roomkin.stages.contracts.scenes import Held
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.geometry.frames import Array, PointMap, invert_transform, project, transform_points, yaw_matrix
from roomkin.stages.geometry.masks import OUTLINE, Mask, lowest_pixels

CONTACT_DISTANCE = 0.045  # metres, besides the error of depth: what is less apart touches, and hides nothing; chosen
BLOCKED = 0.3  # share of the gap that another object fills, from which on that one stands at the wall instead; chosen
MAX_HIDDEN_DEPTH = 0.8  # metres: deepest hidden gap that an object fills, as a deep wardrobe is; chosen
FREE_SHARE = 0.35  # of a gap that is seen to be empty, from which on it is one; chosen
JUST_BELOW = 0.15  # metres; farther down furniture may stand before a picture that hangs; chosen


@dataclass(frozen=True, eq=False)
class DepthView(PointMap):
    """A picture (depth is 0 where it is cropped away) in the floor frame, and how far its depth errs."""

    error: DepthError = USUAL_ERROR

    def distance(self, point: ArrayLike) -> float:
        """Distance in metres from the camera to a point of the floor frame."""
        return float(np.linalg.norm(np.asarray(point, dtype=float) - self.frame[:3, 3]))

    def tolerance(self, point: ArrayLike) -> float:
        """Gap in metres that counts as touching at a point of the floor frame."""
        return CONTACT_DISTANCE + self.error.predict(self.distance(point))

    def project(self, points: Array) -> Array:
        """Pixels (N, 2) of points (N, 3) of the floor frame; NaN behind the camera."""
        return project(transform_points(invert_transform(self.frame), points), self.intrinsics)

    def outline(self, point: ArrayLike) -> float:
        """Metres by which the outline of a mask may be off at a point of the floor frame."""
        return OUTLINE * (self.distance(point) / float(self.intrinsics[0, 0]))

    def share_free(self, points: Array, own: Mask) -> float:
        """Share of the points (N, 3), floor frame, that an object with the mask `own` (H, W) does not fill.

        Were the point part of the object, its pixel would show the object, or something nearer that
        hides it. A pixel that shows neither tells that the point is empty. 0 if no point is in the picture.
        """
        in_camera = transform_points(invert_transform(self.frame), points)
        pixels = project(in_camera, self.intrinsics)
        height, width = self.depth.shape
        columns, rows = np.rint(np.where(np.isfinite(pixels), pixels, -1)).astype(int).T
        inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        columns, rows, z = columns[inside], rows[inside], in_camera[inside, 2]
        shown = self.depth[rows, columns]
        hidden = own[rows, columns] | (shown < z - CONTACT_DISTANCE - self.error.a - self.error.b * z**2)
        return float((~hidden[shown > 0]).mean()) if (shown > 0).any() else 0.0

    def intersect_level(self, columns: NDArray[np.integer], rows: NDArray[np.integer], height: float) -> Array:
        """Points (N, 3) where rays through pixels (N,), (N,) meet z = `height` in the floor frame, else NaN."""
        pixels = np.stack([columns, rows, np.ones_like(rows)], axis=1).astype(np.float64)
        rays = pixels @ np.linalg.inv(self.intrinsics).T @ self.frame[:3, :3].T
        down = np.where(rays[:, 2] < 0, rays[:, 2], np.nan)
        return self.frame[:3, 3] + rays * ((height - self.frame[2, 3]) / down)[:, None]


def resolve_stated_mounting(held: Held, box: UprightBox, shown: dict[int, Wall]) -> tuple[Mounting | None, str]:
    """The mounting that the input states (A.2: by a captioner), with ids of walls; None: it cannot be, and why.

    Args:
        box: of what was seen of the object.
        shown: walls by the mask values that show them.
    """
    names = []
    for value in held.walls:
        if value not in shown:
            return None, f"no wall is found in mask {value}, at which the input states it"
        wall = shown[value]
        if (gap := make_gap(box, wall).depth) > MAX_HIDDEN_DEPTH:
            return None, f"{wall.id}, at which the input states it, is {gap:.1f} m behind it"
        names.append(wall.id)
    return Mounting(type=held.type, walls=list(dict.fromkeys(names))), ""


@dataclass(frozen=True)
class Gap:
    """Space between an object and a wall, as ranges along the wall and in height, and its depth."""

    normal: NDArray[np.float64]
    offset: float
    along: tuple[float, float]
    height: tuple[float, float]
    depth: float

    def points(self, along: tuple[float, float], height: tuple[float, float]) -> NDArray[np.float64]:
        """A grid over part of the gap, in the floor frame."""
        counts = [1 if low == high else 8 for low, high in (along, height)]
        low = np.array([along[0], height[0], 0.2 * self.depth])
        high = np.array([along[1], height[1], self.depth])
        tangent = [-self.normal[1], self.normal[0], 0.0]
        local = cell_centers(low, high, (*counts, 5))
        return local @ np.stack([tangent, [0.0, 0.0, 1.0], self.normal]) + self.offset * self.normal

    def free_share(self, view: DepthView, own: NDArray[np.bool_], inset: float) -> float:
        """Share of it that the camera sees to be empty, from above or from either side, whichever is most."""
        (left, right), (bottom, top) = self.along, self.height
        left, right, top = left + inset, right - inset, top - inset
        faces = [((left, right), (top, top)), ((left, left), (bottom, top)), ((right, right), (bottom, top))]
        return max(view.share_free(self.points(along, height), own) for along, height in faces)

    def is_blocked(self, others: list[UprightBox]) -> bool:
        """Whether another object stands in it."""
        points = self.points(self.along, self.height)
        filled = np.zeros(len(points), dtype=bool)
        for other in others:
            local = (points - other.center) @ yaw_matrix(other.yaw)
            filled |= (np.abs(local) < other.size / 2).all(axis=1)
        return bool(filled.mean() > BLOCKED)


def make_gap(box: UprightBox, wall: Wall) -> Gap:
    """The space between a box and the plane of a wall; its depth is negative if they intersect.

    Its width is that of the box's side that faces the wall. The corners of a box whose yaw errs stick out beyond it,
    and there the wall is always seen.
    """
    normal = np.asarray(wall.normal)
    tangent = np.array([-normal[1], normal[0], 0.0])
    depth = float((corners(box) @ normal).min() - wall.offset)
    middle = float(box.center @ tangent)
    half = float(np.abs(box.size[:2] * (tangent @ yaw_matrix(box.yaw))[:2]).max()) / 2
    return Gap(normal, wall.offset, (middle - half, middle + half), (box.bottom, box.top), depth)


def find_touched_walls(
    box: UprightBox,
    others: list[UprightBox],
    walls: list[Wall],
    view: DepthView,
    own: NDArray[np.bool_],
    max_hidden_depth: float = MAX_HIDDEN_DEPTH,
) -> list[Wall]:
    """The walls that the object touches, the one it leans on with its widest face first.

    Args:
        box: of what was seen of it, at its `own` pixels (H, W).
        others: boxes of all other objects.
        max_hidden_depth: metres of hidden space that it may fill; 0: its box is known whole.
    """
    tolerance, outline = view.tolerance(box.center), view.outline(box.center)
    touched = []
    for wall in walls:
        gap = make_gap(box, wall)
        hidden = (
            tolerance < gap.depth <= max_hidden_depth
            and gap.free_share(view, own, outline) < FREE_SHARE
            and not gap.is_blocked(others)
        )
        in_front = float(box.center @ gap.normal - gap.offset) > -tolerance  # not behind a free-standing wall
        if (gap.depth <= tolerance and in_front) or hidden:
            touched.append((gap.along[0] - gap.along[1], wall.id, wall))
    return [wall for _, _, wall in sorted(touched, key=lambda entry: entry[:2])]


def extend_to_wall(box: UprightBox, wall: Wall) -> UprightBox:
    """The box with its rear face moved to the wall, to find out what stands on it."""
    normal = np.asarray(wall.normal)
    turn = yaw_matrix(box.yaw)
    axis = int(np.argmax(np.abs(turn.T[:2] @ normal)))
    outward = turn[:, axis] * np.sign(turn[:, axis] @ normal)
    front = float(box.center @ outward + box.size[axis] / 2)
    if front <= wall.offset:
        return box
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    size[axis] = front - wall.offset
    center += outward * ((front + wall.offset) / 2 - center @ outward)
    return UprightBox(center, size, box.yaw)


def is_hanging(box: UprightBox, beneath: float, view: DepthView, own: Mask) -> bool:
    """Whether an object at a wall is seen to end above the height `beneath` of the surface below; `own`: pixels (H, W).

    Depth errs along the line of sight, so the lower edge is as sharp as the picture at any distance. Legs are too thin
    to have trusted depth, but their ends are in the mask: rays through the lowest pixels of what stands meet the
    surface inside the footprint, of what hangs far behind it. Just below what hangs the camera sees empty space.
    """
    if box.bottom - beneath <= view.outline(box.center):
        return False
    hits = view.intersect_level(*lowest_pixels(own), beneath)
    if int(_is_over(hits, box, view.tolerance(box.center)).sum()) >= OUTLINE:
        return False
    half = box.size[:2] / 2
    low = max(beneath, box.bottom - JUST_BELOW)
    local = cell_centers(np.array([*-half, low]), np.array([*half, box.bottom]), (6, 6, 8))
    return view.share_free(local @ yaw_matrix(box.yaw).T + [*box.center[:2], 0.0], own) >= FREE_SHARE


def measure_shelf(box: UprightBox, walls: Sequence[Wall], view: DepthView, own: Mask, unnamed: Mask) -> float | None:
    """Height of an unnamed surface, e.g. a shelf, just below most of the object's lowest pixels; None: there is none.

    A wall carries nothing, whether it has a mask there or not.

    Args:
        box: of what was seen of the object, at its `own` pixels (H, W).
        unnamed: pixels (H, W) of no mask.
    """
    tolerance = view.tolerance(box.center)
    columns, rows = lowest_pixels(own)
    inside = rows + 2 * OUTLINE < own.shape[0]
    columns, rows = columns[inside], rows[inside] + OUTLINE
    shown = unnamed[rows, columns] & unnamed[rows + OUTLINE, columns] & (view.depth[rows, columns] > 0)
    points = view.points[rows[shown], columns[shown]]
    near = _is_over(points, box, 2 * tolerance) & (np.abs(points[:, 2] - box.bottom) < tolerance)
    for wall in walls:
        near &= points @ np.array(wall.normal) - wall.offset > tolerance
    return float(np.median(points[near, 2])) if near.sum() > len(columns) / 2 else None


def _is_over(points: NDArray[np.float64], box: UprightBox, margin: float) -> Mask:
    """Which points (N, 3) lie over the footprint of a box, widened by `margin` metres."""
    local = (points - box.center) @ yaw_matrix(box.yaw)
    return np.asarray((np.abs(local[:, :2]) <= box.size[:2] / 2 + margin).all(axis=1))


def cell_centers(low: Array, high: Array, counts: tuple[int, ...]) -> Array:
    """Cell centers (N, d) of a regular grid between two corners (d,)."""
    axes = [lo + (np.arange(n) + 0.5) / n * (hi - lo) for lo, hi, n in zip(low, high, counts, strict=True)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
