"""What tasks do besides the task: films for people, `render`; an object's friction and mass drawn by episode."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from mani_skill.envs.sapien_env import BaseEnv
from mani_skill.utils.structs import Articulation
from sapien.physx import PhysxArticulation, PhysxMaterial

from roomkin.stages.config.training import RandomiseOptions
from roomkin.stages.simulation.film_renderer import FilmRenderer, Shot
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import AcdcPanda
from roomkin.stages.simulation.room import Moment, Prop, Recording, TaskRoom
from roomkin.stages.simulation.target import Target


class Factors(NamedTuple):
    """Factors on friction of the surfaces, mass of the links, and friction and damping of the joints."""

    friction: float
    mass: float
    joint_friction: float


def sample_factors(seed: int, options: RandomiseOptions) -> Factors:
    """The factors of episode `seed`, log-uniform in their ranges: half and double are equally likely."""
    rng = np.random.default_rng((seed, 4))
    ranges = (options.friction, options.mass, options.joint_friction)
    return Factors(*(float(np.exp(rng.uniform(*np.log(each)))) for each in ranges))


def randomise(body: PhysxArticulation, factors: Factors) -> None:
    """Change an articulation that was just built."""
    for link in body.links:
        link.mass, link.inertia = link.mass * factors.mass, link.inertia * factors.mass
        for shape in link.collision_shapes:
            was = shape.physical_material  # shared with other bodies
            friction = (was.static_friction * factors.friction, was.dynamic_friction * factors.friction)
            shape.physical_material = PhysxMaterial(*friction, was.restitution)
    for joint in body.active_joints:
        joint.set_friction(joint.friction * factors.joint_friction)
        joint.set_drive_properties(stiffness=joint.stiffness, damping=joint.damping * factors.joint_friction)


class FilmedEnv(BaseEnv):
    """A ManiSkill environment with an asset that can be filmed."""

    agent: AcdcPanda
    asset_folder: Path
    joint_name: str
    object: Articulation
    room: TaskRoom | None
    scales: Array
    targets: list[Target]

    def success_opening(self, index: int = 0) -> float:
        """The fraction of the range that counts as open."""
        raise NotImplementedError

    def props(self) -> list[tuple[Prop, Array]]:
        """Bodies besides robot and asset that are shown, with their poses (4, 4) in the world."""
        return []

    def moment(self, index: int = 0) -> Moment:
        """Poses and joints of robot, asset and props in environment `index`, for a film."""
        bodies = (self.agent.robot, self.object)
        poses = [body.pose[index].sp.to_transformation_matrix() for body in bodies]
        each = [([joint.name for joint in body.active_joints], body.get_qpos()[index].tolist()) for body in bodies]
        joints = [dict(zip(names, values, strict=True)) for names, values in each]
        return Moment(poses[0], joints[0], poses[1], joints[1], [pose for _, pose in self.props()])

    def recording(self, moments: Sequence[Moment], index: int = 0) -> Recording:
        """Moments of this episode with the asset at its size; to be filmed before `close`."""
        props = [prop for prop, _ in self.props()]
        side = -1.0 if props else self.targets[index].side  # what stands to the robot's left is seen from there
        return Recording(self.asset_folder, self.scales[index], side, moments, self.room, props)

    def render_rgb_array(self, camera_name: str | None = None) -> torch.Tensor:
        """(N, H, W, 3) uint8: each environment in a copy of its own, by a camera that sees hand and door or drawer,
        closed and open; as large as `human_render_camera_configs={"width": ..., "height": ...}` says."""
        pictures = [self._shot(index).picture(self.moment(index)) for index in range(self.num_envs)]
        return torch.from_numpy(np.stack(pictures))

    def cut(self, indices: Iterable[int]) -> None:
        """The next pictures of these environments are of another episode."""
        for index in indices:
            if shot := self._shots.pop(index, None):
                shot.close()

    @cached_property
    def _shots(self) -> dict[int, Shot]:
        """By environment, those of the present episodes."""
        return {}

    @cached_property
    def _renderers(self) -> dict[int, FilmRenderer]:
        """By environment, once it is rendered; policies see nothing of them."""
        return {}

    def _shot(self, index: int) -> Shot:
        if index not in self._shots:
            target, now = self.targets[index], self.moment(index)
            opened = target.lower + self.success_opening(index) * (target.upper - target.lower)
            then = replace(now, asset_joints={**now.asset_joints, self.joint_name: opened})
            if index not in self._renderers:
                asked = self._custom_human_render_camera_configs or {}
                sides = {side: asked[side] for side in ("width", "height") if side in asked}
                self._renderers[index] = FilmRenderer(**sides)
            self._shots[index] = Shot(self._renderers[index], self.recording([now, then], index), [now, then])
        return self._shots[index]
