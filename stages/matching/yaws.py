"""How an object may stand, by its box and its mounting alone: along the wall that it touches, else along its box."""

import numpy as np

from stages.contracts import Objects
from stages.contracts.objects import SceneObject, Wall
from stages.geometry.frames import wrap_angle


def touched_wall(item: SceneObject, scene: Objects) -> Wall | None:
    """The wall that an object touches, the dominant one if there are more."""
    names = item.mounting.walls if item.mounting is not None and item.mounting.type != 2 else []
    return next((wall for wall in scene.walls if wall.id in names[:1]), None)


def aligned_yaws(item: SceneObject, wall: Wall | None) -> list[float]:
    """The four yaws, floor frame, along the wall, the one with the front away from it first; else along the box."""
    assert item.box is not None
    first = item.box.yaw if wall is None else float(np.arctan2(wall.normal[1], wall.normal[0]))
    return [wrap_angle(first + quarter) for quarter in np.arange(4) * np.pi / 2]
