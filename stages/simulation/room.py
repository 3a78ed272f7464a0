"""What a task may stand in (the package `in_scene`: generated scenes), and its episodes as poses and joint values.

Recording them costs nothing, and only what is shown is rendered.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeAlias

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation

from roomkin.stages.contracts.generated import Color, Look
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.simulation.rendering import add_block

THICKNESS, WALL_HEIGHT = 0.1, 2.8  # metres; chosen for pictures
BEYOND = 1.5  # metres that floor and walls reach beyond it; chosen for pictures
Array = NDArray[np.float64]


@dataclass(frozen=True)
class ColoredBlock:
    """A box of one color (linear RGB), turned by `yaw` about z; metres."""

    name: str
    center: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float
    color: Color


def make_backdrop(
    boxes: Sequence[UprightBox], walls: Sequence[Wall], camera: Array, look: Look | None = None
) -> list[ColoredBlock]:
    """Make floor and walls. They end a little beyond the furniture in `boxes`, or where the picture ends.

    A wall with furniture behind it is left out: its end is unknown.

    Args:
        camera: its position (3,); the floor reaches below it.
        look: colors and bounds of surfaces that the picture shows; others get the usual colors.
    """
    seen = {surface.id: surface for surface in look.surfaces} if look else {}
    points = np.concatenate([corners(box) for box in boxes] + [camera[None]])
    shown, edges = [], []
    for wall in walls:
        normal = np.asarray(wall.normal)
        if any(box.center @ normal < wall.offset for box in boxes):
            continue
        tangent = np.array([-normal[1], normal[0], 0.0])
        along = points @ tangent
        left, right, height, color = along.min() - BEYOND, along.max() + BEYOND, WALL_HEIGHT, (0.86, 0.85, 0.82)
        if wall.id in seen:
            (left, _), (right, height), color = seen[wall.id].low, seen[wall.id].high, seen[wall.id].colour
            edges.append(wall.offset * normal[None, :2] + np.outer([left, right], tangent[:2]))
        center = normal * (wall.offset - THICKNESS / 2) + tangent * (left + right) / 2 + [0, 0, height / 2]
        yaw = float(np.arctan2(normal[1], normal[0]))
        shown.append(_block(wall.id, center, [THICKNESS, right - left, height], yaw, color))
    low, high = points[:, :2].min(axis=0) - BEYOND, points[:, :2].max(axis=0) + BEYOND
    color = (0.62, 0.57, 0.50)
    if "floor" in seen:
        color = seen["floor"].colour
        low = np.min([low, seen["floor"].low, *(edge.min(axis=0) for edge in edges)], axis=0)
        high = np.max([high, seen["floor"].high, *(edge.max(axis=0) for edge in edges)], axis=0)
    floor = _block("floor", [*(low + high) / 2, -THICKNESS / 2], [*(high - low), THICKNESS], 0.0, color)
    return [floor, *shown]


def _block(name: str, center: Sequence[float] | Array, size: Sequence[float], yaw: float, color: Color) -> ColoredBlock:
    x, y, z = (float(value) for value in center)
    a, b, c = (float(value) for value in size)
    return ColoredBlock(name, (x, y, z), (a, b, c), yaw, color)


def add_backdrop(
    scene: sapien.Scene, boxes: Sequence[UprightBox], walls: Sequence[Wall], camera: Array, look: Look | None = None
) -> list[sapien.Entity]:
    """Add the blocks of `make_backdrop` to a scene."""
    blocks = make_backdrop(boxes, walls, camera, look)
    return [add_block(scene, block.center, block.size, block.color, block.name, block.yaw) for block in blocks]


Body: TypeAlias = PhysxArticulation | sapien.Entity


class TaskRoom(Protocol):
    """Furniture, floor and walls about the object of a task; its own frame is then the world, z up, metres."""

    @property
    def world_from_nominal(self) -> Array:
        """(4, 4) pose of the frame in which the object's box stands above the origin, on z = 0, and faces +x."""
        ...

    def stand(self, base: Array) -> Array:
        """Where the robot stands, (4, 4), of its pose (4, 4) in the object's nominal frame."""
        ...

    def load(self, scene: sapien.Scene) -> Mapping[str, Body]:
        """Add all but the object, which stays where it is; by name."""
        ...

    @property
    def obstacles(self) -> Mapping[str, Array]:
        """(N, 3) points on the surfaces about, by name, as far as the robot may reach."""
        ...


@dataclass(frozen=True)
class Moment:
    """The state at one moment: (4, 4) poses of the roots in the world, joint values by name."""

    robot: Array
    robot_joints: Mapping[str, float]
    asset: Array
    asset_joints: Mapping[str, float]
    props: Sequence[Array] = ()


@dataclass(frozen=True)
class Prop:
    """A rigid thing of a task besides robot and asset: its asset folder and scale (3,)."""

    folder: Path
    scale: Array


@dataclass(frozen=True)
class Recording:
    """An episode on the asset in `folder`, stretched by `scale` (3,); `side` is +1 or -1 along y, away from a door's
    hinge, 0 for a drawer; `room`: the generated scene that it happened in, whose floor frame is then the world."""

    folder: Path
    scale: Array
    side: float
    moments: Sequence[Moment]
    room: TaskRoom | None = None
    props: Sequence[Prop] = ()
