"""ManiSkill's Panda with few triangles, moved by delta poses of the hand: IK, joint drives (paper B.3)."""

import hashlib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import sapien
import torch
from mani_skill import PACKAGE_ASSET_DIR
from mani_skill.agents.base_agent import Keyframe
from mani_skill.agents.controllers import PDEEPoseController, PDEEPoseControllerConfig, PDJointPosMimicControllerConfig
from mani_skill.agents.registration import register_agent
from mani_skill.agents.robots import Panda
from mani_skill.utils.structs import Pose
from scipy.spatial.transform import Rotation

from roomkin.stages.geometry.frames import quaternion_from_matrix
from roomkin.stages.simulation import kinematics
from roomkin.stages.simulation.kinematics import Array, Chain, read_chain
from roomkin.stages.simulation.rendering import cache_folder, keep


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


PANDA = Path(PACKAGE_ASSET_DIR) / "robots" / "panda" / "panda_v2.urdf"
TCP = "panda_hand_tcp"

# The hand 0.42 m in front of the base and 0.55 m above it, pitched 0.7 rad below the horizontal, fingers closing
# sideways: folded enough to leave room for a door, 0.46 rad from every joint limit, and with the pitch at which the
# arm can follow the whole arc of a door from nearly everywhere (from half of the places with 0.35 rad).
REST = np.array([0.0, -0.876, 0.0, -2.609, 0.0, 2.603, np.pi / 4])
GRIPPER_OPEN, GRIPPER_CLOSED = 0.04, -0.01  # finger joint targets, metres; below zero keeps a force on thin handles
MATERIAL = '<material name="arm"><color rgba="0.9 0.9 0.91 1"/></material>'


@dataclass(frozen=True)
class ActionScale:
    """What action 1 means: metres and radians per control step."""

    position: float = 0.05
    rotation: float = 0.2


@cache
def low_poly_urdf() -> Path:
    """The Panda with its collision shapes as visuals: 2,400 triangles instead of 135,000.

    Software rendering is bound by vertices, so that a depth image takes a tenth of the time.
    """
    tree = ElementTree.parse(PANDA)
    for link in tree.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for index, collision in enumerate(link.findall("collision")):
            visual = ElementTree.Element("visual", collision.attrib)
            visual.extend([*collision, ElementTree.fromstring(MATERIAL)])
            link.insert(index, visual)
    for mesh in tree.iter("mesh"):
        mesh.set("filename", str(PANDA.parent / str(mesh.get("filename")).removeprefix(f"{PANDA.parent}/")))
    text = ElementTree.tostring(tree.getroot(), encoding="unicode")
    folder = cache_folder() / f"panda-{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    semantics = PANDA.with_suffix(".srdf").read_text(encoding="utf-8")
    return keep(folder, {"panda.srdf": semantics, "panda.urdf": text}) / "panda.urdf"


@cache
def panda_chain() -> Chain:
    """Kinematics of the arm from its root link to the tool center point between the finger pads."""
    return read_chain(PANDA, TCP)


@cache
def rest_quaternion() -> Array:
    """(4,) orientation wxyz of the tool center point at rest, in the base frame."""
    return quaternion_from_matrix(panda_chain().pose(REST[None])[0, :3, :3])


@register_agent()
class AcdcPanda(Panda):
    """Panda whose actions are end-effector steps in [-1, 1]; see `ActionScale`."""

    uid = "acdc_panda"
    keyframes = {"rest": Keyframe(pose=sapien.Pose(), qpos=np.append(REST, [GRIPPER_OPEN, GRIPPER_OPEN]))}
    # Stock damping of 100 makes the arm lag its target by a step and a half at 10 Hz.
    arm_damping = 60.0
    # 45 N on a 1 cm handle: the stock 15 N lets go of heavy doors and of drawers that are pulled fast.
    gripper_stiffness = 3e3

    def __init__(self, *args: Any, scale: ActionScale | None = None, **kwargs: Any) -> None:
        self.action_scale = scale or ActionScale()
        self.urdf_path = str(low_poly_urdf())
        super().__init__(*args, **kwargs)

    @property
    def _controller_configs(self) -> dict[str, Any]:
        scale = self.action_scale
        arm: dict[str, Any] = {
            "joint_names": self.arm_joint_names,
            "pos_lower": -scale.position,
            "pos_upper": scale.position,
            # The stock controller multiplies a rotation by its lower bound: positive keeps the sign.
            "rot_lower": scale.rotation,
            "rot_upper": scale.rotation,
            "stiffness": self.arm_stiffness,
            "damping": self.arm_damping,
            "force_limit": self.arm_force_limit,
            "ee_link": self.ee_link_name,
            "urdf_path": self.urdf_path,
        }
        gripper = PDJointPosMimicControllerConfig(
            self.gripper_joint_names, lower=GRIPPER_CLOSED, upper=GRIPPER_OPEN, stiffness=self.gripper_stiffness,
            damping=self.gripper_damping, force_limit=self.gripper_force_limit,
            mimic={"panda_finger_joint2": {"joint": "panda_finger_joint1"}},
        )  # fmt: skip
        return {
            "pd_ee_dls": {"arm": PDEEPoseDLSConfig(**arm), "gripper": gripper},
            "pd_ee_target_delta_pose": {"arm": PDEEPoseControllerConfig(**arm, use_target=True), "gripper": gripper},
        }


def batch_poses(matrices: Array) -> Pose:
    """(N, 4, 4) -> a batched pose."""
    raw = [np.concatenate([pose.p, pose.q]) for pose in map(sapien.Pose, matrices)]
    return Pose.create(torch.as_tensor(np.stack(raw), dtype=torch.float32))
