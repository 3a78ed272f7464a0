"""Pictures of the robot at work, for people: a lit room with a floor, and all of the scene in the picture.

A renderer is a scene of its own; policies never see it.
"""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation
from sapien.physx import PhysxArticulationLinkComponent as Link
from trimesh.bounds import corners

from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.simulation.framing import frame_all, intrinsics_of
from roomkin.stages.simulation.loading import load_asset, move, remove
from roomkin.stages.simulation.rendering import RenderCamera, add_block, make_scene
from roomkin.stages.simulation.robot import PANDA
from roomkin.stages.simulation.room import Body, Moment, Prop, Recording

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
T = TypeVar("T")

GLANCE = 120  # pixels: width of the pictures by which a view is chosen
HAND = "panda_hand_tcp"  # between the fingers
HAND_DEPTH = 0.08  # metres from what is seen to the hand, if that is what is seen
ROOM_MARGIN = 0.15  # metres of a room that are shown about robot and asset


class FilmRenderer:
    """Takes pictures of episodes. One per process, as the first picture of a scene takes seconds.

    Args:
        light: direction in which the key light shines; usually onto the front of the asset, which faces +x.
        width, height: of the pictures, pixels; height: three quarters of the width unless it is given.
    """

    def __init__(
        self, light: Sequence[float] = (-0.8, -0.45, -1.0), width: int = 480, height: int | None = None
    ) -> None:
        self.scene = make_scene(light=light)
        loader = self.scene.create_urdf_loader()
        loader.fix_root_link = True
        self.robot: PhysxArticulation = loader.load(str(PANDA))
        self.aspect = (height or round(0.75 * width)) / width
        sizes = [(each, round(each * self.aspect)) for each in (width, GLANCE)]
        self.camera, self.finder = (RenderCamera(self.scene, intrinsics_of(*s), *s, pack="minimal") for s in sizes)

    def film(self, recording: Recording, frames: int) -> list[Image]:
        """`frames` pictures (H, W, 3), evenly over the recording, from a camera that sees all of it; one per
        moment if there are fewer."""
        moments = pick_evenly(recording.moments, min(frames, len(recording.moments)))
        shot = Shot(self, recording, moments)
        pictures = [shot.picture(moment) for moment in moments]
        shot.close()
        return pictures


class Shot:
    """An episode in a renderer with a fixed camera. Close it before the next one begins.

    Args:
        moments: moments of the episode, or expected ones; the camera is placed so that it shows all of them.
    """

    def __init__(self, renderer: FilmRenderer, recording: Recording, moments: Sequence[Moment]) -> None:
        self.renderer, self.scene, self.robot = renderer, renderer.scene, renderer.robot
        things: list[Recording | Prop] = [recording, *recording.props]
        self.asset, *self.props = (
            load_asset(self.scene, thing.folder, sapien.Pose(), True, f"thing_{number}", thing.scale)
            for number, thing in enumerate(things)
        )
        self._put(moments[0])
        feet, room = [_bounds(self.asset.links), _bounds(self.robot.links[:1])], recording.room
        floor = 0.0 if room else min(box[0, 2] for box in feet)
        self.about = [*room.load(self.scene).values()] if room else _add_room(self.scene, floor, feet[0][0, 0])
        raised = [box for box in feet[bool(room) :] if box[0, 2] - floor > 0.005]
        self.about += [_add_plinth(self.scene, box, floor) for box in raised]
        boxes = [np.array([[*box[0, :2], floor], box[1]]) for box in feet]
        for moment in moments:
            self._put(moment)
            links = [link for body in (self.asset, self.robot) for link in body.links if link.collision_shapes]
            boxes += [_bounds([link]) for link in links]
        points = np.concatenate([corners(box) for box in boxes])
        self.world_from_camera = self._view(recording, points, pick_evenly(moments, 3)[1:])

    def picture(self, moment: Moment) -> Image:
        """(H, W, 3) RGB of a moment."""
        self._put(moment)
        return self.renderer.camera.render(self.world_from_camera).rgb

    def close(self) -> None:
        """Take all but the robot out of the renderer."""
        for body in (self.asset, *self.props, *self.about):
            remove(self.scene, body)

    def _view(self, recording: Recording, points: Array, moments: Sequence[Moment]) -> Array:
        """(4, 4) world_from_camera that shows all points (N, 3), the first that shows the hand most often.

        The asset's front, and so its opening, is always before the camera.
        """
        turn, places = np.eye(3), directions(recording.side)
        if recording.room:
            turn = recording.room.world_from_nominal[:3, :3]
            points = np.concatenate([points + offset for offset in corners([[-ROOM_MARGIN] * 3, [ROOM_MARGIN] * 3])])
        elif recording.side:  # nothing stands on the side to which a door opens
            places = places[: len(places) // 2]
        best, most = np.eye(4), -1
        for direction in places:
            view = frame_all(points, turn @ direction, self.renderer.aspect)
            often = sum(self._sees_hand(view, moment) for moment in moments)
            if often > most:
                best, most = view, often
            if most == len(moments):
                break
        return best

    def _sees_hand(self, view: Array, moment: Moment) -> bool:
        """Whether nothing is before the hand for a camera (4, 4)."""
        self._put(moment)
        depth = self.renderer.finder.render(view).depth
        hand = next(link.pose.p for link in self.robot.links if link.name == HAND)
        point = transform_points(invert_transform(view), np.array(hand, float))
        column, row = np.rint((intrinsics_of(*depth.shape[::-1]) @ point)[:2] / point[2]).astype(int)
        return not 0 < depth[row, column] < point[2] - HAND_DEPTH

    def _put(self, moment: Moment) -> None:
        for prop, place in zip(self.props, moment.props, strict=True):
            move(prop, sapien.Pose(place))
        for body, pose, joints in (
            (self.asset, moment.asset, moment.asset_joints), (self.robot, moment.robot, moment.robot_joints),
        ):  # fmt: skip
            body.set_root_pose(sapien.Pose(pose))
            body.set_qpos(np.array([joints[joint.name] for joint in body.active_joints], np.float32))


def _add_room(scene: sapien.Scene, floor: float, back: float) -> list[Body]:
    """A floor, and a wall behind the asset."""
    return [
        add_block(scene, [0, 0, floor - 0.05], [24, 24, 0.1], (0.42, 0.29, 0.19), "floor"),
        add_block(scene, [back - 0.08, 0, floor + 2], [0.1, 24, 4], (0.36, 0.47, 0.52), "wall"),
    ]


def _add_plinth(scene: sapien.Scene, bounds: Array, floor: float) -> Body:
    """A plinth beneath a body that does not reach the floor."""
    width = np.minimum(0.92 * np.ptp(bounds, axis=0)[:2], 0.6)
    center = [*bounds[:, :2].mean(axis=0), (bounds[0, 2] + floor) / 2]
    return add_block(scene, center, [*width, bounds[0, 2] - floor], (0.62, 0.60, 0.57), "plinth")


def pick_evenly(items: Sequence[T], count: int) -> list[T]:
    """`count` items evenly over an episode, the first and the last included; where there are fewer, some twice."""
    return [items[i] for i in np.linspace(0, len(items) - 1, count).round().astype(int)]


def directions(side: float) -> list[Array]:
    """Unit vectors (3,) from the scene to where a camera may stand, in the asset's frame, the likeliest first: next to
    the robot, where no opened door is in the way; nearer to the front and higher, where more is seen into things."""
    first = 1.0 if side >= 0 else -1.0
    found = [np.array([x, y, z]) for y in (first, -first) for z in (0.45, 0.9) for x in (0.75, 1.5)]
    return [each / np.linalg.norm(each) for each in found]


def _bounds(links: Sequence[Link]) -> Array:
    """(2, 3) lowest and highest corner of a box around links, in the world; tight ones err on stretched hulls."""
    boxes = np.array([link.get_global_aabb_fast() for link in links if link.collision_shapes])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
