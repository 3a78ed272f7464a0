"""Floor and walls of a generated scene, as blocks in the simulator."""

from collections.abc import Sequence

import numpy as np
import sapien
from numpy.typing import NDArray

from stages.contracts.objects import Wall
from stages.geometry.boxes import UprightBox, corners
from stages.simulation.rendering import add_block

THICKNESS, WALL_HEIGHT, BEYOND = 0.1, 2.8, 1.5
FLOOR_COLOUR, WALL_COLOUR = (0.62, 0.57, 0.50), (0.86, 0.85, 0.82)


def add_backdrop(
    scene: sapien.Scene, boxes: Sequence[UprightBox], walls: Sequence[Wall], camera: NDArray[np.float64]
) -> list[sapien.Entity]:
    """Add the floor and the walls as far as the furniture in `boxes` reaches and a little beyond.

    A wall that has furniture behind it is left out: a plane says nothing of where a wall ends.
    """
    points = np.concatenate([corners(box) for box in boxes] + [camera[None]])
    low, high = points.min(axis=0) - BEYOND, points.max(axis=0) + BEYOND
    center, size = (low + high) / 2, high - low
    floor_center, floor_size = [center[0], center[1], -THICKNESS / 2], [size[0], size[1], THICKNESS]
    blocks = [add_block(scene, floor_center, floor_size, FLOOR_COLOUR, "floor")]
    for wall in walls:
        normal = np.asarray(wall.normal)
        if any(np.asarray(box.center) @ normal < wall.offset for box in boxes):
            continue
        tangent = np.array([-normal[1], normal[0], 0.0])
        along = points @ tangent
        left, right = along.min() - BEYOND, along.max() + BEYOND
        middle = normal * (wall.offset - THICKNESS / 2) + tangent * (left + right) / 2 + [0, 0, WALL_HEIGHT / 2]
        yaw = float(np.arctan2(normal[1], normal[0]))
        blocks.append(
            add_block(scene, middle.tolist(), [THICKNESS, right - left, WALL_HEIGHT], WALL_COLOUR, wall.id, yaw)
        )
    return blocks
