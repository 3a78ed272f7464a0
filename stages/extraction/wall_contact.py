"""Which walls an object touches, as the input states it or by geometry (paper A.2, types 1 and 3).

A single picture shows one side of an object. A gap between it and a wall counts only if the camera sees into it;
hidden space is taken to be filled by the object.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.contracts.objects import Mounting, Wall
from stages.contracts.scenes import Held
from stages.extraction.visibility import DepthView, cell_centres
from stages.geometry.boxes import UprightBox, corners
from stages.geometry.frames import yaw_matrix
from stages.geometry.masks import OUTLINE

BLOCKED = 0.3  # share of the gap that another object fills, from which on that one stands at the wall instead; chosen
MAX_HIDDEN_DEPTH = 0.8  # metres: deepest hidden gap that an object fills, as a deep wardrobe is; chosen
FREE_SHARE = 0.35  # of a gap that is seen to be empty, from which on it is one; chosen


class ImpossibleError(Exception):
    """The stated mounting is impossible; the one by geometry is used."""


def resolve_stated_mounting(held: Held, box: UprightBox, shown: dict[int, Wall]) -> Mounting:
    """The mounting that the input states (A.2: by a captioner), with ids of walls.

    Args:
        box: of what was seen of the object.
        shown: walls by the mask values that show them.

    Raises:
        ImpossibleError: a wall has no plane, or is too far behind the object.
    """
    names = []
    for value in held.walls:
        if value not in shown:
            raise ImpossibleError(f"no wall is found in mask {value}, at which the input states it")
        wall = shown[value]
        if (gap := make_gap(box, wall).depth) > MAX_HIDDEN_DEPTH:
            raise ImpossibleError(f"{wall.id}, at which the input states it, is {gap:.1f} m behind it")
        names.append(wall.id)
    return Mounting(type=held.type, walls=list(dict.fromkeys(names)))


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
        local = cell_centres(low, high, (*counts, 5))
        return local @ np.stack([tangent, [0.0, 0.0, 1.0], self.normal]) + self.offset * self.normal

    def free_share(self, view: DepthView, own: NDArray[np.bool_], inset: float) -> float:
        """Share of it that the camera sees to be empty, from above or from either side, whichever is most."""
        (left, right), (bottom, top) = self.along, self.height
        left, right, top = left + inset, right - inset, top - inset
        faces = [((left, right), (top, top)), ((left, left), (bottom, top)), ((right, right), (bottom, top))]
        return max(view.free_share(self.points(along, height), own) for along, height in faces)

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
    tolerance, outline = view.tolerance(box.center), OUTLINE * view.pixel_size(view.distance(box.center))
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
