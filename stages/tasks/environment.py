"""The base of the tasks: a ManiSkill environment with a Panda before one articulated asset (paper B.3, B.4)."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import sapien
import torch
from mani_skill.envs.sapien_env import BaseEnv
from mani_skill.sensors.camera import CameraConfig
from mani_skill.utils.structs import Articulation, Pose
from mani_skill.utils.structs.types import SceneConfig, SimConfig
from numpy.typing import NDArray

from stages.config.task import TaskConfig
from stages.geometry.frames import inverse
from stages.simulation import observation
from stages.simulation.kinematics import Array
from stages.simulation.loading import asset_builder, close
from stages.simulation.robot import GRIPPER_OPEN, REST, AcdcPanda, ActionScale, panda_chain
from stages.simulation.target import Target, descends, read_target
from stages.tasks.cameras import Camera, jitter, shoulder
from stages.tasks.initial_state import base_pose, draw_initial_state, object_motion
from stages.tasks.observation import Observation
from stages.tasks.task import Task

SIMULATION_FREQUENCY = 100
FILM = "film"
OFFICIAL_SUCCESS = 0.1  # of the range of any joint (official code)


class OpenTaskEnv(BaseEnv):
    """Open one joint of one asset with a fixed-base Panda.

    The robot stands in front of the handle, at a height relative to it. There is no floor: nothing falls.
    A task's own class names its `task` and overrides what differs: `cameras`, `seen_ids` (what the cloud shows),
    `succeeded`, `_load_scene` (more objects), `_initialize_episode` (where they are; the seed is in `_episode_seed`).

    Args:
        asset_folder: folder with asset.json. A change takes effect at reset(options={"reconfigure": True}).
        joint: name of the joint to open.
        options: the `task` section.
    """

    SUPPORTED_ROBOTS = ["acdc_panda"]
    SUPPORTED_REWARD_MODES = ("sparse", "none")
    task: ClassVar[Task]
    agent: AcdcPanda

    def __init__(
        self,
        *args: Any,
        asset_folder: str | Path,
        joint: str,
        options: TaskConfig | None = None,
        robot_uids: str = "acdc_panda",
        **kwargs: Any,
    ) -> None:
        self.options = options or TaskConfig()
        self.asset_folder, self.joint_name = Path(asset_folder), joint
        kwargs.setdefault("control_mode", self.options.controller)
        super().__init__(*args, robot_uids=robot_uids, **kwargs)

    @property
    def max_episode_steps(self) -> int:
        """Steps after which an episode is truncated; ManiSkill's wrappers ask for it under this name."""
        return self.options.max_steps or self.task.horizon

    def step(self, action: Any) -> tuple[Any, Any, torch.Tensor, torch.Tensor, dict[str, Any]]:
        """ManiSkill's step, truncated at the task's own horizon."""
        observation, reward, terminated, _, info = super().step(action)
        return observation, reward, terminated, self.elapsed_steps >= self.max_episode_steps, info

    @property
    def _default_sim_config(self) -> SimConfig:
        return SimConfig(
            sim_freq=SIMULATION_FREQUENCY,
            control_freq=self.options.control_frequency,
            scene_config=SceneConfig(solver_position_iterations=15, solver_velocity_iterations=1, contact_offset=0.02),
        )

    @property
    def _default_sensor_configs(self) -> list[CameraConfig]:
        return [camera.config(self.agent, self.options) for camera in self.cameras()]

    def cameras(self) -> Sequence[Camera]:
        """The depth cameras whose points make up the cloud."""
        return [shoulder(self.options)]

    @property
    def _default_human_render_camera_configs(self) -> list[CameraConfig]:
        pose = camera_pose_from([-0.1, -1.15, 0.95], [0.45, 0.0, 0.42])
        return [
            CameraConfig(
                uid=FILM,
                pose=pose,
                width=320,
                height=320,
                fov=1.0,
                near=0.05,
                far=10.0,
                mount=self.agent.robot.root,
                shader_pack="default",
            )
        ]

    def _load_agent(self, options: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        scale = ActionScale(
            position=self.options.position_step,
            rotation=self.options.rotation_step,
            from_target=self.options.delta_from == "target",
        )
        # Well away from the asset until the episode is initialised.
        self.agent = AcdcPanda(
            self.scene, self._control_freq, self._control_mode, initial_pose=sapien.Pose([5, 0, 0]), scale=scale
        )

    def _load_scene(self, options: dict[str, Any]) -> None:
        loader = self.scene.create_urdf_loader()
        loader.name = "target_object"
        self.asset, builder = asset_builder(loader, self.asset_folder, fixed=True)
        builder.initial_pose = sapien.Pose()
        self.object: Articulation = builder.build()
        for articulation in self.object._objs:
            close(articulation)

    def _load_lighting(self, options: dict[str, Any]) -> None:
        """For film strips alone: the policy's camera has no use for light."""
        self.scene.set_ambient_light([0.45, 0.45, 0.45])
        self.scene.add_directional_light([-0.3, 0.5, -1.0], [1.0, 1.0, 1.0])
        self.scene.add_directional_light([-1.0, -0.6, -0.3], [0.6, 0.6, 0.6])

    def _after_reconfigure(self, options: dict[str, Any]) -> None:
        self.target: Target = read_target(self.object, self.joint_name)
        self._official = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)

    def seen_ids(self, index: int = 0) -> NDArray[np.int16]:
        """Entity ids of what the cloud of environment `index` shows: the target link, or by `task.cloud` all links."""
        body = self.object._objs[index]
        moved = body.active_joints[self.target.index].child_link
        links = [link for link in body.links if self.options.cloud == "object" or descends(link, moved)]
        return np.array([link.entity.per_scene_id for link in links], np.int16)

    def _initialize_episode(self, env_idx: torch.Tensor, options: dict[str, Any]) -> None:
        indices = env_idx.tolist()
        setups = [draw_initial_state(int(self._episode_seed[i]), self.options) for i in indices]
        # The nominal object stands with its box centre above the origin and its box on z = 0.
        center = (np.array(self.asset.box_min) + np.array(self.asset.box_max)) / 2
        nominal = np.array([-center[0], -center[1], -self.asset.box_min[2]])
        handle = self.target.reference + nominal
        shift = np.eye(4)
        shift[:3, 3] = nominal
        bases = np.stack([base_pose(handle, self.target.side, setup, self.options) for setup in setups])
        roots = np.stack([object_motion(setup) @ shift for setup in setups])
        fingers = [GRIPPER_OPEN, GRIPPER_OPEN]
        qpos = np.stack([np.append(REST + setup.joints, fingers) for setup in setups])
        self.agent.robot.set_qpos(torch.as_tensor(qpos, dtype=torch.float32, device=self.device))
        self.agent.robot.set_pose(to_poses(bases))
        self.object.set_pose(to_poses(roots))
        self.object.set_qpos(self.object.get_qlimits()[env_idx, :, 0])
        self.object.set_qvel(torch.zeros_like(self.object.get_qvel()[env_idx]))
        self._official[env_idx] = False
        self._place_cameras(indices)

    def _place_cameras(self, indices: Sequence[int]) -> None:
        """Jitter the cameras of each environment; where they then are is known to the robot."""
        for number, camera in enumerate(self.cameras()):
            for index in indices:
                shift = jitter(int(self._episode_seed[index]), number, self.options)
                pose = camera.pose()
                pose[:3, 3] += shift[:3, 3]
                pose[:3, :3] = shift[:3, :3] @ pose[:3, :3]
                self._camera_poses[camera.name, index] = pose
                if camera.name in self._sensors:
                    component = self._sensors[camera.name].camera._render_cameras[index]
                    component.set_local_pose(sapien.Pose(pose))

    @cached_property
    def _camera_poses(self) -> dict[tuple[str, int], Array]:
        """(4, 4) pose of a camera of an environment, in the frame of its mount."""
        return {}

    def opened(self) -> torch.Tensor:
        """(N,) fraction of the target joint's range, 0 closed, 1 fully open."""
        return self._fractions()[:, self.target.index]

    def _fractions(self) -> torch.Tensor:
        """(N, J) fraction of the range of every joint; 0 for one that turns without end."""
        limits = self.object.get_qlimits()
        span = limits[..., 1] - limits[..., 0]
        return torch.where(span.isfinite(), (self.object.get_qpos() - limits[..., 0]) / span, 0.0)

    @property
    def success_opening(self) -> float:
        """The fraction of the range that counts as open: half, 60 degrees or 15 cm, whichever is less."""
        options, target = self.options, self.target
        enough = np.deg2rad(options.success_angle) if target.revolute else options.success_distance
        return float(min(options.success_fraction, enough / (target.upper - target.lower)))

    def succeeded(self) -> torch.Tensor:
        """(N,) the one success criterion, for demonstrations and evaluation alike."""
        return self.opened() >= self.success_opening

    def evaluate(self) -> dict[str, torch.Tensor]:
        """Success; beside it the official code's: any joint of the object was 10 % open at any time."""
        self._official |= (self._fractions() >= OFFICIAL_SUCCESS).any(dim=1)
        return {"success": self.succeeded(), "official_success": self._official.clone(), "opened": self.opened()}

    def observe(self, index: int = 0, render: bool = True) -> Observation:
        """What a policy sees in environment `index`; without `render` the cloud is empty."""
        options, chain = self.options, panda_chain()
        joints = self.agent.robot.get_qpos()[index].cpu().numpy().astype(np.float64)
        tcp, fingers = chain.pose(joints[None, :7])[0], joints[7:]
        cloud = np.zeros((options.points, 4), np.float32)
        if render:
            finger = observation.finger_points(tcp, fingers, options.finger_points)
            cloud = observation.unified_cloud(self._scene_points(index, tcp), finger, options.points)
        rest = chain.pose(REST[None])[0]
        return {"point_cloud": cloud, "proprio": observation.proprioception(tcp, fingers, rest)}

    def _scene_points(self, index: int, tcp: Array) -> NDArray[np.float32]:
        """(N, 3) points of all cameras inside the workspace, in the base frame; `tcp` (4, 4)."""
        self.scene.update_render(update_sensors=True, update_human_render_cameras=False)
        low, high = np.array(self.options.workspace_min), np.array(self.options.workspace_max)
        ids, clouds = self.seen_ids(index), []
        for camera in self.cameras():
            sensor = self._sensors[camera.name]
            sensor.capture()
            image = sensor.camera.get_picture("PositionSegmentation")[0][index].cpu().numpy()
            local = self._camera_poses[camera.name, index]
            pose = local if camera.mount == "base" else tcp @ local
            clouds.append(observation.object_points(image, ids, pose, low, high))
        return np.concatenate(clouds)

    def _get_obs_extra(self, info: dict[str, Any]) -> dict[str, torch.Tensor]:
        return {"tcp_pose": self.agent.tcp.pose.raw_pose, "opened": info["opened"][:, None]}

    def obstacles(self) -> Array:
        """(N, 3) points on what stands about besides the object, in the robot base frame: a skill keeps clear of it."""
        return np.zeros((0, 3))

    def base_from_asset(self, index: int = 0) -> Array:
        """(4, 4) pose of the asset's root in the robot base frame."""
        base = self.agent.robot.pose.sp if self.num_envs == 1 else self.agent.robot.pose[index].sp
        root = self.object.pose.sp if self.num_envs == 1 else self.object.pose[index].sp
        return np.asarray(inverse(base.to_transformation_matrix()) @ root.to_transformation_matrix(), dtype=float)


def to_poses(matrices: Array) -> Pose:
    """(N, 4, 4) -> a batched pose."""
    return Pose.create(torch.as_tensor(np.stack([_raw(m) for m in matrices]), dtype=torch.float32))


def _raw(matrix: Array) -> Array:
    pose = sapien.Pose(matrix)
    return np.concatenate([pose.p, pose.q])


def camera_pose_from(eye: Sequence[float], target: Sequence[float]) -> sapien.Pose:
    """Pose of a camera at `eye` that looks at `target`, z up."""
    from mani_skill.utils import sapien_utils

    return sapien_utils.look_at(eye, target).sp
