"""How an object may stand, by what is known besides its picture: its front, the walls that it touches, its box."""

import numpy as np

from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.objects import SceneObject, Wall
from roomkin.stages.geometry.frames import wrap_angle


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
