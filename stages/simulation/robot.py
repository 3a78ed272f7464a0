"""The robot: ManiSkill's Panda with few triangles and end-effector pose controllers (paper B.3)."""

import hashlib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import sapien
from mani_skill import PACKAGE_ASSET_DIR
from mani_skill.agents.base_agent import Keyframe
from mani_skill.agents.controllers import PDEEPoseControllerConfig, PDJointPosMimicControllerConfig
from mani_skill.agents.registration import register_agent
from mani_skill.agents.robots import Panda

from roomkin.stages.geometry.frames import quaternion_from_matrix
from roomkin.stages.simulation.controller import PDEEPoseDLSConfig
from roomkin.stages.simulation.kinematics import Array, Chain, read_chain
from roomkin.stages.simulation.shaders import cache_folder, keep

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
            self.gripper_joint_names,
            lower=GRIPPER_CLOSED,
            upper=GRIPPER_OPEN,
            stiffness=self.gripper_stiffness,
            damping=self.gripper_damping,
            force_limit=self.gripper_force_limit,
            mimic={"panda_finger_joint2": {"joint": "panda_finger_joint1"}},
        )
        return {
            "pd_ee_dls": {"arm": PDEEPoseDLSConfig(**arm), "gripper": gripper},
            "pd_ee_target_delta_pose": {"arm": PDEEPoseControllerConfig(**arm, use_target=True), "gripper": gripper},
        }
