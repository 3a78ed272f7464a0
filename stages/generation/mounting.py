"""Fit boxes to walls: what touches a wall ends at it, and nothing reaches into one (paper A.3)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from roomkin.stages.contracts.objects import Wall
from roomkin.stages.generation.turning import ALONG_SIDE
from roomkin.stages.geometry.boxes import THINNEST, UprightBox, corners, depth_behind, volume
from roomkin.stages.geometry.frames import yaw_matrix

PLACE_TOLERANCE = 0.05  # metres by which a place may be missed: of the floor, of a wall; chosen


def fit_stated_box(box: UprightBox, yaw: float, walls: Sequence[Wall]) -> UprightBox:
    """A box that the input tells, with the axes of a model at `yaw`, which run along its own; it ends at the walls."""
    size = box.size.copy()
    if round((yaw - box.yaw) / (np.pi / 2)) % 2:
        size[:2] = size[1::-1]
    box = UprightBox(box.center, np.maximum(size, THINNEST), yaw)
    for wall in walls:
        box = min(box, extend_to_wall(box, wall), key=volume)
    return box


def extend_to_wall(box: UprightBox, wall: Wall) -> UprightBox:
    """The box rescaled along its own axis so that its rear reaches the wall and its front stays where it is.

    If the box is turned a little against the wall (the second wall of a corner), its edge touches the wall.
    """
    normal = np.asarray(wall.normal, dtype=float)
    along = normal @ yaw_matrix(box.yaw)
    axis = int(np.argmax(np.abs(along[:2])))
    if abs(along[axis]) < np.cos(ALONG_SIDE):
        return box
    size = box.size.copy()
    edges = size[1 - axis] * abs(along[1 - axis])  # how much farther than its middle the turned faces reach, both
    front = float((corners(box) @ normal).max())
    size[axis] = max((front - wall.offset - edges) / abs(along[axis]), THINNEST)
    middle = wall.offset + (size[axis] * abs(along[axis]) + edges) / 2
    shift = yaw_matrix(box.yaw)[:, axis] * (middle - box.center @ normal) / along[axis]
    return UprightBox(box.center + shift, size, box.yaw)


def move_to_wall(box: UprightBox, wall: Wall) -> UprightBox:
    """The box moved so that it ends at a wall, if it nearly does."""
    depth = depth_behind(box, wall.normal, wall.offset)
    return replace(box, center=box.center + depth * np.asarray(wall.normal)) if abs(depth) < PLACE_TOLERANCE else box


def move_out_of_walls(box: UprightBox, walls: list[Wall]) -> UprightBox:
    """The box moved out of the walls that it reaches into, if its center is in front of them."""
    for wall in walls:
        normal, depth = np.asarray(wall.normal, dtype=float), depth_behind(box, wall.normal, wall.offset)
        if depth > 0 and box.center @ normal > wall.offset:
            box = replace(box, center=box.center + depth * normal)
    return box
