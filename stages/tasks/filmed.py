"""What people see of a task: what a film needs to be recorded, and `render`."""

from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from mani_skill.envs.sapien_env import BaseEnv
from mani_skill.utils.structs import Articulation

from stages.plugins import load
from stages.simulation.kinematics import Array
from stages.simulation.recording import Moment, Prop, Recording
from stages.simulation.robot import AcdcPanda
from stages.simulation.room import Room
from stages.simulation.target import Target


class FilmedEnv(BaseEnv):
    """A ManiSkill environment with an asset that can be filmed."""

    agent: AcdcPanda
    asset_folder: Path
    joint_name: str
    object: Articulation
    room: Room | None
    scales: Array
    targets: list[Target]

    def success_opening(self, index: int = 0) -> float:
        """The fraction of the range that counts as open."""
        raise NotImplementedError

    def props(self) -> list[tuple[Prop, Array]]:
        """What is shown besides robot and asset, with its pose (4, 4) in the world."""
        return []

    def moment(self, index: int = 0) -> Moment:
        """Poses and joints of robot, asset and props in environment `index`, for a film."""
        bodies = (self.agent.robot, self.object)
        poses = [body.pose[index].sp.to_transformation_matrix() for body in bodies]
        joints = [
            dict(zip((joint.name for joint in body.active_joints), body.get_qpos()[index].tolist(), strict=True))
            for body in bodies
        ]
        return Moment(poses[0], joints[0], poses[1], joints[1], [pose for _, pose in self.props()])

    def recording(self, moments: Sequence[Moment], index: int = 0) -> Recording:
        """Moments of this episode with the asset at its size; to be filmed before `close`."""
        props = [prop for prop, _ in self.props()]
        side = -1.0 if props else self.targets[index].side  # what stands to the robot's left is seen from there
        return Recording(self.asset_folder, self.scales[index], side, moments, self.room, props)

    def render_rgb_array(self, camera_name: str | None = None) -> torch.Tensor:
        """(N, H, W, 3) uint8: each environment in a copy of its own, by a camera that sees hand and door or drawer,
        closed and open; as large as `human_render_camera_configs={"width": ..., "height": ...}` says."""
        return torch.from_numpy(np.stack([self.renderer.picture(index) for index in range(self.num_envs)]))

    @cached_property
    def renderer(self) -> Any:
        """What renders for people; policies see nothing of it."""
        return load("renderers", "film_renderer")(self)

    def cut(self, indices: Iterable[int]) -> None:
        """The next pictures of these environments are of another episode."""
        if "renderer" in self.__dict__:
            self.renderer.cut(indices)
