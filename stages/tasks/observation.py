"""What a policy is given at each step, by the environment as by the stores (paper B.3)."""

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy as np
import sapien
from mani_skill.sensors.camera import CameraConfig
from numpy.typing import NDArray

from stages.contracts.task_options import TaskConfig
from stages.simulation.depth_shaders import PICTURE
from stages.simulation.kinematics import Array
from stages.simulation.observation import finger_points, object_points, proprioception, unified_cloud
from stages.simulation.robot import REST, AcdcPanda, panda_chain
from stages.tasks.cameras import Camera, jitter

Float = NDArray[np.float32]


class Observation(TypedDict):
    """What a policy sees, in the robot base frame.

    point_cloud: (P, 4) float32 xyz in metres and a flag: 0 scene, 1 gripper finger. Fingers come last.
    proprio: (9,) float32 end-effector position, quaternion wxyz, the two finger joints.
    """

    point_cloud: Float
    proprio: Float


class CameraRig:
    """The cameras of a task's environments, and what they see of them."""

    def __init__(self, cameras: Sequence[Camera], options: TaskConfig) -> None:
        self.cameras, self.options = cameras, options
        self._poses: dict[tuple[str, int], Array] = {}  # of a camera in an environment, in the frame of its mount

    def configs(self, robot: AcdcPanda) -> list[CameraConfig]:
        """The cameras as ManiSkill makes them."""
        return [camera.config(robot, self.options) for camera in self.cameras]

    def place(self, sensors: Mapping[str, Any], index: int, seed: int) -> None:
        """Jitter the cameras of environment `index` for episode `seed`; where they then are is known to the robot."""
        for number, camera in enumerate(self.cameras):
            shift = jitter(seed, number, self.options)
            pose = camera.pose()
            pose[:3, 3] += shift[:3, 3]
            pose[:3, :3] = shift[:3, :3] @ pose[:3, :3]
            self._poses[camera.name, index] = pose
            if camera.name in sensors:
                sensors[camera.name].camera._render_cameras[index].set_local_pose(sapien.Pose(pose))

    def capture(self, sensors: Mapping[str, Any]) -> list[NDArray[np.int16]]:
        """(N, H, W, 4) picture of every camera in N environments: position in millimetres, entity id."""
        for camera in self.cameras:
            sensors[camera.name].capture()
        return [sensors[camera.name].camera.get_picture(PICTURE)[0].cpu().numpy() for camera in self.cameras]

    def observation(
        self, joints: Array, pictures: Sequence[NDArray[np.int16]], shown: NDArray[np.int16], index: int
    ) -> Observation:
        """What a policy sees in environment `index`.

        Args:
            joints: (9,) measured ones of arm and fingers.
            pictures: of every camera, from `capture`; none: the cloud is empty.
            shown: entity ids that the cloud shows.
        """
        options, chain = self.options, panda_chain()
        tcp, fingers = chain.pose(joints[None, :7])[0], joints[7:]
        cloud = np.zeros((options.points, 4), np.float32)
        if pictures:
            low, high = np.array(options.workspace_min), np.array(options.workspace_max)
            clouds = []
            for camera, picture in zip(self.cameras, pictures, strict=True):
                local = self._poses[camera.name, index]
                pose = local if camera.mount == "base" else tcp @ local
                clouds.append(object_points(picture[index], shown, pose, low, high))
            finger = finger_points(tcp, fingers, options.finger_points)
            cloud = unified_cloud(np.concatenate(clouds), finger, options.points)
        rest = chain.pose(REST[None])[0]
        return {"point_cloud": cloud, "proprio": proprioception(tcp, fingers, rest)}
