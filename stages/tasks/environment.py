"""The base of the tasks: a ManiSkill environment with a Panda before one articulated asset (paper B.3, B.4)."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import sapien
import torch
from mani_skill.sensors.camera import CameraConfig
from mani_skill.utils.structs import Articulation
from mani_skill.utils.structs.types import SceneConfig, SimConfig
from numpy.typing import NDArray

from roomkin.stages.config.training import RandomiseOptions
from roomkin.stages.contracts.policy_config import SIMULATION_FREQUENCY, TaskConfig
from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.planning.clearance import Surroundings
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.loading import ParsedAsset, load_asset, physics_scene, set_joint_dynamics
from roomkin.stages.simulation.rendering import render_backend
from roomkin.stages.simulation.robot import GRIPPER_OPEN, REST, AcdcPanda, ActionScale, batch_poses
from roomkin.stages.simulation.room import TaskRoom
from roomkin.stages.simulation.target import Target, descends, read_target
from roomkin.stages.tasks.base_placement import OFFICIAL_SUCCESS_FRACTION, find_success_opening, place_robot_and_asset
from roomkin.stages.tasks.filmed import FilmedEnv, randomise, sample_factors
from roomkin.stages.tasks.initial_state import nominal_root, sample_initial_state, sample_scale
from roomkin.stages.tasks.observation import CameraRig, MountedCamera, Observation, Sensing, shoulder
from roomkin.stages.tasks.task import Task

LARGEST_ID = 30_000  # of an entity: a picture holds 16 bits of it, and every change of scale takes new ones


class OpenTaskEnv(FilmedEnv):
    """Open one joint of one asset with a fixed-base Panda.

    The robot stands in front of the handle, at a height relative to it. There is no floor: nothing falls.
    A task's own class, if it has one, overrides what differs: `cameras`, `seen_ids` (what the cloud shows),
    `check_success`, `_load_scene` (more objects), `_initialize_episode` (where they are, how far joints are open; the
    seed is in `_episode_seed`), `evaluate` (beside success, the official code's).

    Args:
        task: what the skill is to do there, which says what is opened.
        asset_folder: folder with asset.json. It and `joint_name` may be set anew; the next episode shows the change.
        joint: name of the joint to open; None: the one that suits the task best.
        options: the `task` section, or some of its keys.
        vary_scale: draw the asset's scale with the episode; on a GPU, where a scene cannot change, when it is built.
        randomise: draw its friction and mass likewise, and its scale from this range, not `scale_range`.
        room: a generated scene about the asset; the world is then its floor frame.
        sensing: how the cameras differ from perfect ones.
        obs_mode: 'pointcloud' (what a policy sees: `Observation`), 'state', 'none', or another of ManiSkill's.
    """

    SUPPORTED_ROBOTS = ["acdc_panda"]
    SUPPORTED_REWARD_MODES = ("sparse", "none")
    simulation_frequency: ClassVar[int] = SIMULATION_FREQUENCY  # a task may have a multiple of it
    robot_shift: ClassVar[tuple[float, float, float]] = (0.0, 0.0, 0.0)  # metres: out from the front, y, up
    agent: AcdcPanda

    def __init__(
        self,
        *args: Any,
        task: Task,
        asset_folder: str | Path,
        joint: str | None = None,
        options: TaskConfig | dict[str, Any] | None = None,
        robot_uids: str = "acdc_panda",
        vary_scale: bool = True,
        randomise: RandomiseOptions | dict[str, Any] | None = None,
        room: TaskRoom | None = None,
        sensing: Sensing | None = None,
        obs_mode: str = "pointcloud",
        **kwargs: Any,
    ) -> None:
        self.task, self.options = task, TaskConfig.model_validate(options or {})
        self.asset_folder, self.room = Path(asset_folder), room
        self.randomise = RandomiseOptions.model_validate(randomise) if randomise else None
        drawn_from = self.randomise.extents if self.randomise else self.options.scale_range
        self.scale_range = drawn_from if vary_scale else None
        self.joint_name = joint or self.task.suitable_joint(self.asset_folder)
        self.rig = CameraRig(self.cameras(), self.options, sensing)
        known = {"control_mode": self.options.controller, "sim_backend": self.options.sim_backend}
        known |= {"render_backend": render_backend()} | kwargs
        super().__init__(*args, robot_uids=robot_uids, obs_mode=obs_mode, **known)

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
            sim_freq=self.simulation_frequency,
            control_freq=self.options.control_frequency,
            scene_config=SceneConfig(solver_position_iterations=15, solver_velocity_iterations=1, contact_offset=0.02),
        )

    @property
    def _default_sensor_configs(self) -> list[CameraConfig]:
        return self.rig.configs(self.agent)

    def cameras(self) -> Sequence[MountedCamera]:
        """The depth cameras whose points make up the cloud."""
        return [shoulder(self.options)]

    def _load_agent(self, options: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        task = self.options
        scale = ActionScale(task.position_step, task.rotation_step)
        away = sapien.Pose([5, 0, 0])  # from the asset, until the episode is initialised
        self.agent = AcdcPanda(self.scene, self._control_freq, self._control_mode, initial_pose=away, scale=scale)

    def _load_scene(self, options: dict[str, Any]) -> None:
        self._parsed: dict[Path, ParsedAsset] = {}  # of this scene
        self._load_object(self._drawn_scales(self._episode_seed))
        if self.room:
            for scene in self.scene.sub_scenes:
                self.room.load(scene)

    def _drawn_scales(self, seeds: Sequence[int]) -> Array:
        return np.array([sample_scale(int(seed), self.options, self.scale_range) for seed in seeds])

    def _load_object(self, scales: Array) -> None:
        """Put the asset into every environment at its scale, (N, 3)."""
        if self.asset_folder not in self._parsed:
            loader = self.scene.create_urdf_loader()
            loader.name = "target_object"
            self._parsed[self.asset_folder] = ParsedAsset(loader, self.asset_folder, fixed=True)
        parsed = self._parsed[self.asset_folder]
        self.asset, self.scales, self._loaded = parsed.asset, scales, (self.asset_folder, self.joint_name)
        alike = bool((scales == scales[0]).all())
        bodies = []
        for index, scale in enumerate(scales[:1] if alike else scales):
            builder = parsed.builder(scale)
            builder.initial_pose = sapien.Pose()
            builder.set_scene_idxs(range(self.num_envs) if alike else [index])
            bodies.append(builder.build(name="target_object" if alike else f"target_object_{index}"))
        self.object: Articulation = bodies[0] if alike else Articulation.merge(bodies, name="target_object")
        names = [joint.name for joint in bodies[0].active_joints]
        for body, seed in zip(self.object._objs, self._episode_seed, strict=True):
            set_joint_dynamics(body, self.asset, names)
            if self.randomise:
                randomise(body, sample_factors(int(seed), self.randomise))
        index = names.index(self.joint_name)
        if self.gpu_sim_enabled:  # what is on the GPU cannot be measured before the first step: measure a twin of it
            world = physics_scene()
            shown = [load_asset(world, self.asset_folder, sapien.Pose(), True, "", scale) for scale in scales]
        else:
            self.object.set_qpos(self.object.get_qlimits()[..., 0])
            shown = self.object._objs
        self.targets: list[Target] = [read_target(body, index) for body in shown]
        self._surroundings: dict[int, Surroundings] = {}  # by environment

    @property
    def target(self) -> Target:
        """The target of the first environment, of the only one on a CPU."""
        return self.targets[0]

    def _exchange_object(self, scales: Array) -> None:
        """Take the asset out and put the present one in at its scales, (N, 3); everything else stays as it is."""
        self.scene.remove_from_state_dict_registry(self.object)
        self.scene.remove_articulation(self.object)
        self._load_object(scales)
        self.__dict__.pop("segmentation_id_map", None)

    def _load_lighting(self, options: dict[str, Any]) -> None:
        """For film strips alone: the policy's camera has no use for light."""
        self.scene.set_ambient_light([0.45, 0.45, 0.45])
        self.scene.add_directional_light([-0.3, 0.5, -1.0], [1.0, 1.0, 1.0])
        self.scene.add_directional_light([-1.0, -0.6, -0.3], [0.6, 0.6, 0.6])

    def _after_reconfigure(self, options: dict[str, Any]) -> None:
        self._official = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)

    def seen_ids(self, index: int = 0) -> NDArray[np.int16]:
        """Entity ids of what the cloud of environment `index` shows: the target link, or by `task.cloud` all links."""
        body = self.object._objs[index]
        moved = body.active_joints[self.targets[index].index].child_link
        links = [link for link in body.links if self.options.cloud == "object" or descends(link, moved)]
        return np.array([link.entity.per_scene_id for link in links], np.int16)

    def reset(self, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """ManiSkill's; builds the scene again where a new asset needs that, and when the entities' ids are used up."""
        if "object" in self.__dict__:
            other = self.gpu_sim_enabled and self._loaded != (self.asset_folder, self.joint_name)
            if other or self.object._objs[0].links[-1].entity.per_scene_id > LARGEST_ID:
                options = {**(options or {}), "reconfigure": True}
        return super().reset(seed=seed, options=options)

    def _initialize_episode(self, env_idx: torch.Tensor, options: dict[str, Any]) -> None:
        indices = env_idx.tolist()
        seeds = [int(self._episode_seed[i]) for i in indices]
        if not self.gpu_sim_enabled:
            scales = self._drawn_scales(seeds)
            if self.randomise or (scales != self.scales).any() or self._loaded != (self.asset_folder, self.joint_name):
                self._exchange_object(scales)
        bases, roots, qpos = [], [], []
        self.cut(indices)
        for index, seed in zip(indices, seeds, strict=True):
            setup, target = sample_initial_state(seed, self.options), self.targets[index]
            nominal = nominal_root(self.asset, self.scales[index])
            surroundings = None if self.room else partial(self.sample_surroundings, index)
            base, root = place_robot_and_asset(setup, target, nominal, self.options, surroundings, self.robot_shift)
            if self.room:
                base, root = self.room.stand(base), self.room.world_from_nominal @ root
            bases.append(base)
            roots.append(root)
            qpos.append(np.concatenate([REST + setup.joints, [GRIPPER_OPEN, GRIPPER_OPEN]]))
            self.rig.place(self._sensors, index, seed)
        self.agent.robot.set_qpos(torch.as_tensor(np.stack(qpos), dtype=torch.float32, device=self.device))
        self.agent.robot.set_pose(batch_poses(np.stack(bases)))
        self.object.set_pose(batch_poses(np.stack(roots)))
        self.object.set_qpos(self.object.get_qlimits()[env_idx, :, 0])
        self.object.set_qvel(torch.zeros_like(self.object.get_qvel()[env_idx]))
        self._official[env_idx] = False

    def sample_surroundings(self, index: int = 0) -> Surroundings:
        """The object of environment `index`; its surfaces are sampled once."""
        if index not in self._surroundings:
            self._surroundings[index] = Surroundings(self.targets[index])
        return self._surroundings[index]

    def measure_opening(self) -> torch.Tensor:
        """(N,) fraction of the target joint's range, 0 closed, 1 fully open."""
        return self._fractions()[:, self.target.index]

    def _fractions(self) -> torch.Tensor:
        """(N, J) fraction of the range of every joint; 0 for one that turns without end."""
        limits = self.object.get_qlimits()
        span = limits[..., 1] - limits[..., 0]
        return torch.where(span.isfinite(), (self.object.get_qpos() - limits[..., 0]) / span, 0.0)

    def success_opening(self, index: int = 0) -> float:
        """The fraction of the range that counts as open."""
        return find_success_opening(self.targets[index], self.options)

    def check_success(self) -> torch.Tensor:
        """(N,) the one success criterion, for demonstrations and evaluation alike."""
        enough = [self.success_opening(index) for index in range(self.num_envs)]
        return self.measure_opening() >= torch.tensor(enough, device=self.device)

    def evaluate(self) -> dict[str, torch.Tensor]:
        """Success; beside it the official code's: any joint of the object was 10 % open at any time."""
        fractions = self._fractions()
        self._official |= (fractions >= OFFICIAL_SUCCESS_FRACTION).any(dim=1)
        opened, official = fractions[:, self.target.index], self._official.clone()
        return {"success": self.check_success(), "official_success": official, "opened": opened}

    def observe(self, render: bool = True) -> list[Observation]:
        """The observation in each environment; without `render` the clouds are empty."""
        pictures = []
        if render:
            self.scene.update_render(update_sensors=True, update_human_render_cameras=False)
            pictures = self.rig.capture(self._sensors)
        joints = self.agent.robot.get_qpos().cpu().numpy().astype(np.float64)
        return [self.rig.observation(row, pictures, self.seen_ids(i), i) for i, row in enumerate(joints)]

    def get_obs(self, info: dict[str, Any] | None = None, unflattened: bool = False) -> Any:
        """ManiSkill's observation; in mode 'pointcloud' what a policy sees, batched."""
        if self.obs_mode != "pointcloud":
            return super().get_obs(info, unflattened)
        seen = self.observe()
        columns = {"point_cloud": [one["point_cloud"] for one in seen], "proprio": [one["proprio"] for one in seen]}
        return {key: torch.as_tensor(np.stack(rows), device=self.device) for key, rows in columns.items()}

    def _get_obs_extra(self, info: dict[str, Any]) -> dict[str, torch.Tensor]:
        return {"tcp_pose": self.agent.tcp.pose.raw_pose, "opened": info["opened"][:, None]}

    def obstacles(self) -> Array:
        """(N, 3) points on what stands about besides the object, in the robot base frame: a skill keeps clear of it."""
        if self.room is None:
            return np.zeros((0, 3))
        base = self.agent.robot.pose.sp.to_transformation_matrix()
        return transform_points(invert_transform(base), np.concatenate(list(self.room.obstacles.values())))

    def base_from_asset(self) -> Array:
        """(4, 4) pose of the asset's root in the robot base frame, in the first environment."""
        base, root = self.agent.robot.pose[0].sp, self.object.pose[0].sp
        inverse = invert_transform(base.to_transformation_matrix())
        return np.asarray(inverse @ root.to_transformation_matrix(), dtype=float)
