"""The depth cameras of a task (paper B.3): on the robot's base or on its hand, jittered by episode."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import sapien
from mani_skill.sensors.camera import CameraConfig
from scipy.spatial.transform import Rotation

from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.simulation.depth_shaders import depth_shaders
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import AcdcPanda

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Camera:
    """A camera at `eye` that looks at `target`, in the frame of what it is mounted on: the robot's base or its hand
    (tool center point: z towards the object, y from finger to finger). Metres; `up` is up in its picture."""

    name: str
    eye: Place
    target: Place
    mount: Literal["base", "hand"] = "base"
    up: Place = (0.0, 0.0, 1.0)

    def pose(self) -> Array:
        """(4, 4) in the frame of the mount: x forward, y left, z up."""
        forward = np.subtract(self.target, self.eye)
        forward = forward / np.linalg.norm(forward)
        left = np.cross(self.up, forward)
        left /= np.linalg.norm(left)
        return make_transform(np.stack([forward, left, np.cross(forward, left)], axis=1), self.eye)

    def config(self, robot: AcdcPanda, options: TaskConfig) -> CameraConfig:
        """Its config for ManiSkill; it is posed when an episode starts."""
        return CameraConfig(
            uid=self.name,
            pose=sapien.Pose(),
            width=options.camera_size,
            height=options.camera_size,
            fov=options.camera_fov,
            near=0.02,
            far=10.0,
            mount=robot.robot.root if self.mount == "base" else robot.tcp,
            shader_config=depth_shaders(),
        )


# Above the hand, past the fingers: it sees what they close around.
WRIST = Camera("wrist", (-0.09, 0.0, -0.08), (0.0, 0.0, 0.06), "hand", (-1.0, 0.0, 0.0))


def shoulder(options: TaskConfig) -> Camera:
    """The camera over the robot's shoulder."""
    return Camera("shoulder", options.camera_eye, options.camera_target)


def other_shoulder(options: TaskConfig) -> Camera:
    """Its mirror image on the other side of the robot."""
    eye, target = ((x, -y, z) for x, y, z in (options.camera_eye, options.camera_target))
    return Camera("shoulder_2", eye, target)


def jitter(seed: int, number: int, options: TaskConfig) -> Array:
    """(4, 4) shift (uniform per axis) and turn of the `number`th camera in episode `seed`, about its own place."""
    rng = np.random.default_rng((seed, 17, number))
    metres, radians = options.camera_jitter
    turn = rng.standard_normal(3)
    rotation = Rotation.from_rotvec(turn / np.linalg.norm(turn) * rng.uniform(0, radians))
    return make_transform(rotation.as_matrix(), rng.uniform(-1, 1, 3) * metres)


def displace_pose(pose: Array, seed: int, number: int, error: tuple[float, float]) -> Array:
    """A pose (4, 4) shifted and turned by `error` (metres, radians), in directions that the episode draws."""
    shift, axis = np.random.default_rng((seed, 29, number)).standard_normal((2, 3))
    moved = pose.copy()
    moved[:3, 3] += error[0] * shift / np.linalg.norm(shift)
    moved[:3, :3] = Rotation.from_rotvec(error[1] * axis / np.linalg.norm(axis)).as_matrix() @ pose[:3, :3]
    return moved
