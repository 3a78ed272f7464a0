"""The observation of a policy at each step, and the depth cameras on base or hand that it comes from (paper B.3)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypedDict

import numpy as np
import sapien
from mani_skill.sensors.camera import CameraConfig
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.observation import (
    PICTURE,
    depth_shaders,
    finger_points,
    object_points,
    proprioception,
    unify_cloud,
)
from roomkin.stages.simulation.robot import AcdcPanda, panda_chain, rest_quaternion

Place = tuple[float, float, float]


@dataclass(frozen=True)
class MountedCamera:
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
            uid=self.name, pose=sapien.Pose(), width=options.camera_size, height=options.camera_size,
            fov=options.camera_fov, near=0.02, far=10.0, mount=robot.robot.root if self.mount == "base" else robot.tcp,
            shader_config=depth_shaders(),
        )  # fmt: skip


# Above the hand, past the fingers: it sees what they close around.
WRIST = MountedCamera("wrist", (-0.09, 0.0, -0.08), (0.0, 0.0, 0.06), "hand", (-1.0, 0.0, 0.0))


def shoulder(options: TaskConfig) -> MountedCamera:
    """The camera over the robot's shoulder."""
    return MountedCamera("shoulder", options.camera_eye, options.camera_target)


def other_shoulder(options: TaskConfig) -> MountedCamera:
    """Its mirror image on the other side of the robot."""
    eye, target = ((x, -y, z) for x, y, z in (options.camera_eye, options.camera_target))
    return MountedCamera("shoulder_2", eye, target)


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


Float = NDArray[np.float32]


class Observation(TypedDict):
    """An observation of a policy, in the robot base frame.

    point_cloud: (P, 4) float32 xyz in metres and a flag: 0 scene, 1 gripper finger. Fingers come last.
    proprio: (9,) float32 end-effector position, quaternion wxyz, the two finger joints.
    """

    point_cloud: Float
    proprio: Float


# Axial noise of a depth camera, metres at z metres (Nguyen, Izadi & Lovell 2012, of the Kinect): a + b (z - c)^2
NOISE_FLOOR, NOISE_GROWTH, NEAREST = 0.0012, 0.0019, 0.4


@dataclass(frozen=True)
class Sensing:
    """How the cameras differ from perfect ones.

    depth_noise: depth has a depth camera's. camera_error: metres and radians by which a camera is elsewhere than the
    policy is told, in a direction drawn by episode.
    """

    depth_noise: bool = False
    camera_error: tuple[float, float] = (0.0, 0.0)


def with_noise(picture: NDArray[np.int16], rng: np.random.Generator) -> NDArray[np.int16]:
    """A picture (H, W, 4) of positions in millimetres, moved along their rays by a depth camera's error."""
    depth = np.abs(picture[..., 2]) * 1e-3
    error = rng.normal(0.0, 1.0, depth.shape) * (NOISE_FLOOR + NOISE_GROWTH * (depth - NEAREST) ** 2)
    noisy = picture.copy()
    noisy[..., :3] = np.rint(picture[..., :3] * (1 + error / np.maximum(depth, 1e-3))[..., None])
    return noisy


class CameraRig:
    """The cameras of a task's environments, and what they see of them."""

    def __init__(self, cameras: Sequence[MountedCamera], options: TaskConfig, sensing: Sensing | None = None) -> None:
        self.cameras, self.options, self.sensing = cameras, options, sensing or Sensing()
        # By camera and environment, in the frame of its mount: where it is, and where the policy is told that it is.
        self._poses: dict[tuple[str, int], Array] = {}
        self._told: dict[tuple[str, int], Array] = {}
        self._noise: dict[int, np.random.Generator] = {}  # by environment

    def configs(self, robot: AcdcPanda) -> list[CameraConfig]:
        """The cameras as ManiSkill makes them."""
        return [camera.config(robot, self.options) for camera in self.cameras]

    def place(self, sensors: Mapping[str, Any], index: int, seed: int) -> None:
        """Jitter the cameras of environment `index` for episode `seed`; the robot knows where they are, but for
        `Sensing.camera_error`."""
        self._noise[index] = np.random.default_rng((seed, 23))
        for number, camera in enumerate(self.cameras):
            shift = jitter(seed, number, self.options)
            pose = camera.pose()
            pose[:3, 3] += shift[:3, 3]
            pose[:3, :3] = shift[:3, :3] @ pose[:3, :3]
            self._poses[camera.name, index] = pose
            self._told[camera.name, index] = displace_pose(pose, seed, number, self.sensing.camera_error)
            if camera.name in sensors:
                sensors[camera.name].camera._render_cameras[index].set_local_pose(sapien.Pose(pose))

    def pose(self, name: str, index: int) -> Array:
        """(4, 4) of a camera in environment `index`, in the frame of its mount: x forward, y left, z up."""
        return self._poses[name, index].copy()

    def capture(self, sensors: Mapping[str, Any]) -> list[NDArray[np.int16]]:
        """(N, H, W, 4) picture of every camera in N environments: position in millimetres, entity id."""
        for camera in self.cameras:
            sensors[camera.name].capture()
        return [sensors[camera.name].camera.get_picture(PICTURE)[0].cpu().numpy() for camera in self.cameras]

    def observation(
        self, joints: Array, pictures: Sequence[NDArray[np.int16]], shown: NDArray[np.int16], index: int
    ) -> Observation:
        """The observation in environment `index`.

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
                local = self._told[camera.name, index]
                pose = local if camera.mount == "base" else tcp @ local
                seen = with_noise(picture[index], self._noise[index]) if self.sensing.depth_noise else picture[index]
                clouds.append(object_points(seen, shown, pose, low, high))
            finger = finger_points(tcp, fingers, options.finger_points)
            cloud = unify_cloud(np.concatenate(clouds), finger, options.points)
        return {"point_cloud": cloud, "proprio": proprioception(tcp, fingers, rest_quaternion())}
