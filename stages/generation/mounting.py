"""Walls and heights by mounting type: 1 hangs on a wall, 2 stands, 3 stands and touches a wall (paper A.3)."""

from dataclasses import replace

import numpy as np
from shapely import Point
from shapely.ops import nearest_points

from stages.contracts.objects import Wall
from stages.generation.placed import FLOOR, UNNAMED, WALL, Placed
from stages.generation.prisms import steady_region
from stages.generation.support import Beneath
from stages.geometry.boxes import UprightBox, corners
from stages.geometry.frames import yaw_matrix

PARALLEL = np.cos(np.deg2rad(15))  # a wall turned more than this against the box is not one it can lie flat on


def facing_axis(box: UprightBox, wall: Wall) -> int | None:
    """Which of the box's axes, 0 (x) or 1 (y), runs along the wall's normal; None if neither does."""
    along = np.abs(np.asarray(wall.normal) @ yaw_matrix(box.yaw))[:2]
    axis = int(np.argmax(along))
    return axis if along[axis] >= PARALLEL else None


def against_wall(box: UprightBox, wall: Wall, min_extent: float) -> UprightBox:
    """The box rescaled along its own axis so that its rear reaches the wall and its front stays where it is.

    A wall that it is a little turned against (the second one in a corner) it touches with an edge.
    """
    axis = facing_axis(box, wall)
    if axis is None:
        return box
    normal = np.asarray(wall.normal, dtype=float)
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    along = normal @ yaw_matrix(box.yaw)
    edges = size[1 - axis] * abs(along[1 - axis])  # how much farther than its middle the turned faces reach, both
    front = float((corners(box) @ normal).max())
    size[axis] = max((front - wall.offset - edges) / abs(along[axis]), min_extent)
    middle = wall.offset + (size[axis] * abs(along[axis]) + edges) / 2
    center += yaw_matrix(box.yaw)[:, axis] * (middle - center @ normal) / along[axis]
    return UprightBox(center, size, box.yaw)


def at_height(item: Placed, support: str, beneath: float) -> Placed:
    """The item on its support, whose surface is at height `beneath`.

    Type 1 is only lifted out of what is beneath it; types 2 and 3 are put on top of it.
    """
    if item.wall_mounted:
        return replace(item.shifted([0, 0, max(0.0, beneath - item.bottom)]), support=WALL)
    return replace(item.shifted([0, 0, beneath - item.bottom]), support=support)


def on_supports(items: list[Placed], supports: dict[str, str], beneath: Beneath, steady: bool = True) -> list[Placed]:
    """Every item at its height, lower ones first, since a support must be in its place before what it carries.

    Args:
        items: sorted from low to high, so that each comes after its support.
        supports: id -> 'floor', 'unnamed' (it stays at its height) or the id of the item beneath.
        steady: what stands on another but over its edge is moved in, so that it does not fall.
    """
    done: dict[str, Placed] = {}
    for item in items:
        support = supports[item.id]
        if support == UNNAMED:
            done[item.id] = replace(item, support=UNNAMED)
            continue
        if support == FLOOR:
            done[item.id] = at_height(item, support, 0.0)
            continue
        surface = beneath(item, done[support])
        if steady and not item.wall_mounted:
            there, here = nearest_points(steady_region(item, surface.area), Point(item.center[:2]))
            item = item.shifted([there.x - here.x, there.y - here.y, 0.0])
        done[item.id] = at_height(item, support, surface.height)
    return list(done.values())
