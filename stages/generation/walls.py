"""Boxes and walls: what reaches to a wall ends there, and nothing stands in one (paper A.3)."""

from dataclasses import replace

import numpy as np

from stages.contracts.objects import Wall
from stages.geometry.boxes import UprightBox, corners
from stages.geometry.frames import yaw_matrix

CONTACT = 0.05  # metres by which a place may be missed: of the floor, of a wall
ALONG = np.deg2rad(15)  # what is turned less than this against a side runs along it


def against_wall(box: UprightBox, wall: Wall, min_extent: float) -> UprightBox:
    """The box rescaled along its own axis so that its rear reaches the wall and its front stays where it is.

    A wall that it is a little turned against (the second one in a corner) it touches with an edge.
    """
    normal = np.asarray(wall.normal, dtype=float)
    along = normal @ yaw_matrix(box.yaw)
    axis = int(np.argmax(np.abs(along[:2])))
    if abs(along[axis]) < np.cos(ALONG):
        return box
    size = box.size.copy()
    edges = size[1 - axis] * abs(along[1 - axis])  # how much farther than its middle the turned faces reach, both
    front = float((corners(box) @ normal).max())
    size[axis] = max((front - wall.offset - edges) / abs(along[axis]), min_extent)
    middle = wall.offset + (size[axis] * abs(along[axis]) + edges) / 2
    shift = yaw_matrix(box.yaw)[:, axis] * (middle - box.center @ normal) / along[axis]
    return UprightBox(box.center + shift, size, box.yaw)


def out_of_walls(box: UprightBox, walls: list[Wall]) -> UprightBox:
    """The box moved out of the walls that it reaches into, if its centre is in front of them."""
    for wall in walls:
        normal, depth = np.asarray(wall.normal, dtype=float), behind(box, wall)
        if depth > 0 and box.center @ normal > wall.offset:
            box = replace(box, center=box.center + depth * normal)
    return box


def behind(box: UprightBox, wall: Wall) -> float:
    """How far a box reaches behind a wall, metres; negative: it is before it."""
    return wall.offset - float((corners(box) @ np.asarray(wall.normal)).min())


def is_beyond(box: UprightBox, wall: Wall) -> bool:
    """Whether a box lies wholly behind a wall's plane: it is seen, so the wall ends, or has an opening, before it."""
    return float((corners(box) @ np.asarray(wall.normal)).max()) < wall.offset
