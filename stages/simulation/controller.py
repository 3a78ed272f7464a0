"""End-effector pose controller: delta pose in the robot base axes, damped-least-squares IK, joint PD drives."""

from dataclasses import dataclass

import numpy as np
import torch
from mani_skill.agents.controllers import PDEEPoseController, PDEEPoseControllerConfig
from scipy.spatial.transform import Rotation

from roomkin.stages.simulation import kinematics
from roomkin.stages.simulation.kinematics import Array, Chain


def apply_delta(pose: Array, delta: Array) -> Array:
    """Poses (N, 4, 4) moved by `delta` (N, 6): translation, then rotation vector, both in the base axes."""
    moved = pose.copy()
    moved[:, :3, 3] += delta[:, :3]
    moved[:, :3, :3] = Rotation.from_rotvec(delta[:, 3:]).as_matrix() @ pose[:, :3, :3]
    return moved


def scale_action(action: Array, position: float, rotation: float) -> Array:
    """Actions (N, 6) in [-1, 1] -> metres and radians; translation clipped per axis, rotation by its norm."""
    norm = np.linalg.norm(action[:, 3:], axis=1, keepdims=True)
    return np.concatenate(
        [np.clip(action[:, :3], -1, 1) * position, action[:, 3:] / np.maximum(norm, 1.0) * rotation], axis=1
    )


class PDEEPoseDLS(PDEEPoseController):
    """Delta pose control through `kinematics.track`.

    A delta is added to the measured pose: a blocked hand pushes with the force of one step only and a wrong step is
    forgotten, which suits learned policies. Batched; the arithmetic is on the host.
    """

    config: "PDEEPoseDLSConfig"
    chain: Chain

    def _initialize_joints(self) -> None:
        super()._initialize_joints()
        self.chain = kinematics.read_chain(self.config.urdf_path, self.config.ee_link)

    def set_action(self, action: torch.Tensor) -> None:
        """Drive the joints to the IK solution of the commanded pose; `action` (N, 6) in [-1, 1]."""
        delta = scale_action(
            action.detach().cpu().numpy().astype(np.float64), self.config.pos_upper, self.config.rot_upper
        )
        start = self._read_joints()
        target = apply_delta(self.chain.pose(start), delta)
        joints = kinematics.track(self.chain, start, target)
        self._target_qpos = torch.as_tensor(joints, dtype=torch.float32, device=self.device)
        self.set_drive_targets(self._target_qpos)

    def reference_pose(self) -> Array:
        """(N, 4, 4) pose in the base frame that the next delta will be added to."""
        return self.chain.pose(self._read_joints())

    def _read_joints(self) -> Array:
        return self.qpos.cpu().numpy().astype(np.float64)


@dataclass
class PDEEPoseDLSConfig(PDEEPoseControllerConfig):
    """Config of `PDEEPoseDLS`; `pos_upper` and `rot_upper` are metres and radians at action 1."""

    controller_cls = PDEEPoseDLS
