"""Films of episodes after the event: a lit room with a floor, the robot in its own colours, everything in the frame.

Episodes are recorded as poses and joint values, which costs nothing, and only those that are shown are rendered: the
stock Panda has 135,000 triangles, too many for the policy's camera, which sees the low-poly one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation
from sapien.physx import PhysxArticulationLinkComponent as Link
from trimesh.bounds import corners

from stages.geometry.frames import rigid
from stages.simulation.backdrop import FLOOR_COLOUR, WALL_COLOUR
from stages.simulation.loading import load_asset, move, remove
from stages.simulation.rendering import RenderCamera, add_block, instance_id, make_scene
from stages.simulation.robot import PANDA
from stages.simulation.room import Body, Room

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
T = TypeVar("T")

WIDTH, HEIGHT = 360, 288
FIELD_OF_VIEW = 0.7  # radians, across
MARGIN = 1.06  # room around what moves
AROUND = 0.2  # metres of a room that are shown about robot and asset


@dataclass(frozen=True)
class Moment:
    """Where everything is: (4, 4) poses of the roots in the world, joint values by name."""

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
    room: Room | None = None
    props: Sequence[Prop] = ()


class Studio:
    """Renders recordings; made once per process, as the first picture of a scene takes seconds.

    Args:
        light: direction in which the key light shines; usually onto the front of the asset, which faces +x.
    """

    def __init__(self, light: Sequence[float] = (-0.65, -0.35, -1.0)) -> None:
        self.scene = make_scene(light=light)
        loader = self.scene.create_urdf_loader()
        loader.fix_root_link = True
        self.robot: PhysxArticulation = loader.load(str(PANDA))
        focal = WIDTH / 2 / np.tan(FIELD_OF_VIEW / 2)
        intrinsics = [[focal, 0, (WIDTH - 1) / 2], [0, focal, (HEIGHT - 1) / 2], [0, 0, 1]]
        self.camera = RenderCamera(self.scene, intrinsics, WIDTH, HEIGHT)

    def film(self, recording: Recording, frames: int) -> list[Image]:
        """`frames` pictures (HEIGHT, WIDTH, 3), evenly over the recording, from a camera that sees all of it; one per
        moment if there are fewer."""
        moments = evenly(recording.moments, min(frames, len(recording.moments)))
        asset = load_asset(self.scene, recording.folder, sapien.Pose(moments[0].asset), True, "asset", recording.scale)
        props = [
            load_asset(self.scene, prop.folder, sapien.Pose(pose), True, f"prop_{number}", prop.scale)
            for number, (prop, pose) in enumerate(zip(recording.props, moments[0].props, strict=True))
        ]
        self._put(asset, props, moments[0])
        feet = [_bounds(asset.links), _bounds(self.robot.links[:1])]
        low = min(bounds[0, 2] for bounds in feet)
        about = self._in_room(recording.room, feet[1]) if recording.room else self._alone(feet, low)
        seen = [] if recording.room else [corners(np.array([[*box[0, :2], low], box[1]])) for box in feet]
        for moment in moments:
            self._put(asset, props, moment)
            seen += [corners(_bounds([link])) for body in (asset, self.robot) for link in _solid(body.links)]
        world_from_camera = self._view(recording, asset, np.concatenate(seen))
        pictures = []
        for moment in moments:
            self._put(asset, props, moment)
            pictures.append(self.camera.render(world_from_camera).rgb)
        for body in (asset, *props, *about):
            remove(self.scene, body)
        return pictures

    def _alone(self, feet: Sequence[Array], low: float) -> list[sapien.Entity]:
        """Floor, wall, and plinths beneath what does not reach the floor."""
        blocks = [_plinth(self.scene, bounds, low) for bounds in feet if bounds[0, 2] - low > 0.005]
        back = feet[0][0, 0] - 0.03
        blocks.append(add_block(self.scene, [0, 0, low - 0.05], [24, 24, 0.1], FLOOR_COLOUR, "floor"))
        blocks.append(add_block(self.scene, [back - 0.05, 0, low + 2], [0.1, 24, 4], WALL_COLOUR, "wall"))
        return blocks

    def _in_room(self, room: Room, base: Array) -> list[Body]:
        """The room, and a plinth beneath the robot."""
        plinth = [_plinth(self.scene, base, 0.0)] if base[0, 2] > 0.005 else []
        return [*room.load(self.scene).values(), *plinth]

    def _view(self, recording: Recording, asset: PhysxArticulation, points: Array) -> Array:
        """(4, 4) world_from_camera that shows all points (N, 3); in a room, where most is seen of asset and robot.

        The robot counts less: it may hide the asset.
        """
        if recording.room is None:
            return frame_all(points, view_direction(recording.side))
        around = np.stack([points.min(axis=0) - AROUND, points.max(axis=0) + AROUND])
        around[0, 2] = max(around[0, 2], 0.0)

        def seen(view: Array) -> int:
            shown = self.camera.render(view).segmentation
            return 4 * int((shown == instance_id(asset)).sum()) + int((shown == instance_id(self.robot)).sum())

        turn = recording.room.world_from_nominal[:3, :3]
        scales = [np.array([x, y, z]) for z in (1.0, 1.8) for y in (1, -1) for x in (1, 2.5)]
        directions = [turn @ (view_direction(recording.side) * scale) for scale in scales]
        return max((frame_all(corners(around), each / np.linalg.norm(each)) for each in directions), key=seen)

    def _put(self, asset: PhysxArticulation, props: Sequence[Body], moment: Moment) -> None:
        for prop, place in zip(props, moment.props, strict=True):
            move(prop, sapien.Pose(place))
        poses = (asset, moment.asset, moment.asset_joints), (self.robot, moment.robot, moment.robot_joints)
        for body, pose, joints in poses:
            body.set_root_pose(sapien.Pose(pose))
            body.set_qpos(np.array([joints[joint.name] for joint in body.active_joints], np.float32))


def evenly(items: Sequence[T], count: int) -> list[T]:
    """`count` items evenly over an episode, the first and the last included; where there are fewer, some twice."""
    return [items[i] for i in np.linspace(0, len(items) - 1, count).round().astype(int)]


def view_direction(side: float) -> Array:
    """(3,) unit vector from the scene to the camera: beside the robot, where no opened door is in the way."""
    direction = np.array([0.75, 1.0 if side >= 0 else -1.0, 0.5])
    return np.asarray(direction / np.linalg.norm(direction))


def frame_all(points: Array, direction: Array) -> Array:
    """(4, 4) world_from_camera, OpenCV axes: looks against `direction`, as near as all points (N, 3) stay in the frame.

    A point is in the frame if its offsets from the axis stay below its depth times the tangents of the half angles;
    for one viewing direction that is linear in the camera's place, so the nearest place is found directly.
    """
    forward = -direction
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    tangent = np.tan(FIELD_OF_VIEW / 2) / MARGIN
    place = np.zeros(3)
    needed = []
    depth = points @ forward
    for axis, limit in ((right, tangent), (down, tangent * HEIGHT / WIDTH)):
        offset = points @ axis
        high, low = (offset - limit * depth).max(), (offset + limit * depth).min()
        place += axis * (high + low) / 2
        needed.append((high - low) / (2 * limit))
    return rigid(np.stack([right, down, forward], axis=1), place - max(needed) * forward)


def _solid(links: Sequence[Link]) -> list[Link]:
    return [link for link in links if link.collision_shapes]


def _bounds(links: Sequence[Link]) -> Array:
    """(2, 3) lowest and highest corner of a box around links, in the world."""
    boxes = np.array([link.get_global_aabb_fast() for link in _solid(links)])  # the tight ones err on stretched hulls
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _plinth(scene: sapien.Scene, bounds: Array, floor: float) -> sapien.Entity:
    """A plinth beneath a body that does not reach the floor."""
    size = bounds[1] - bounds[0]
    width = np.minimum(0.92 * size[:2], 0.6)
    center = [*(bounds[0, :2] + bounds[1, :2]) / 2, (bounds[0, 2] + floor) / 2]
    return add_block(scene, center, [*width, bounds[0, 2] - floor], FLOOR_COLOUR, "plinth")
