"""Which walls an object touches (paper A.2, types 1 and 3).

A single picture shows one side of things. The gap between an object and a wall counts as a gap only
if the camera has looked into it; what stays hidden is taken to be filled by the object.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.config.extraction import ExtractionConfig
from stages.contracts.objects import Wall
from stages.extraction.masks import OUTLINE
from stages.extraction.visibility import DepthView, cell_centres
from stages.geometry.boxes import UprightBox, corners
from stages.geometry.frames import yaw_matrix

BLOCKED = 0.3  # share of the gap that another object fills, from which on that one stands at the wall instead


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

    def free_space_share(self, view: DepthView, own: NDArray[np.bool_], inset: float) -> float:
        """How much of it the camera sees to be empty, from above or from either side, whichever is most."""
        (left, right), (bottom, top) = self.along, self.height
        left, right, top = left + inset, right - inset, top - inset
        faces = [((left, right), (top, top)), ((left, left), (bottom, top)), ((right, right), (bottom, top))]
        return max(view.free_space_share(self.points(along, height), own) for along, height in faces)

    def blocked(self, others: list[UprightBox]) -> bool:
        """Whether another object stands in it."""
        points = self.points(self.along, self.height)
        filled = np.zeros(len(points), dtype=bool)
        for other in others:
            local = (points - other.center) @ yaw_matrix(other.yaw)
            filled |= (np.abs(local) < other.size / 2).all(axis=1)
        return bool(filled.mean() > BLOCKED)


def gap_to(box: UprightBox, wall: Wall) -> Gap:
    """The space between a box and the plane of a wall; its depth is negative if they intersect.

    Along the wall it is as wide as the side of the box that is turned to it: beyond, where the corners of a box
    stick out whose yaw is a little off, the wall is always seen.
    """
    normal = np.asarray(wall.normal)
    tangent = np.array([-normal[1], normal[0], 0.0])
    depth = float((corners(box) @ normal).min() - wall.offset)
    middle = float(box.center @ tangent)
    half = float(np.abs(box.size[:2] * (tangent @ yaw_matrix(box.yaw))[:2]).max()) / 2
    return Gap(normal, wall.offset, (middle - half, middle + half), (box.bottom, box.top), depth)


def walls_touched(
    box: UprightBox,
    others: list[UprightBox],
    walls: list[Wall],
    view: DepthView,
    own: NDArray[np.bool_],
    options: ExtractionConfig,
) -> list[Wall]:
    """The walls that the object touches, the one it leans on with its widest face first."""
    distance = view.distance(box.center)
    tolerance = options.tolerance(view.error.at(distance))
    touched = []
    for wall in walls:
        gap = gap_to(box, wall)
        hidden = (
            tolerance < gap.depth <= options.max_hidden_depth
            and gap.free_space_share(view, own, OUTLINE * view.pixel_size(distance)) < options.free_space_share
            and not gap.blocked(others)
        )
        in_front = float(box.center @ gap.normal - gap.offset) > -tolerance  # not behind a free-standing wall
        if (gap.depth <= tolerance and in_front) or hidden:
            touched.append((gap.along[0] - gap.along[1], wall.id, wall))
    return [wall for _, _, wall in sorted(touched, key=lambda entry: entry[:2])]


def filled_to(box: UprightBox, wall: Wall) -> UprightBox:
    """The box with its rear face moved to the wall; for finding out what stands on it."""
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
