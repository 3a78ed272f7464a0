"""Roles of joints: doors and drawers, with their handles."""

from collections.abc import Iterable
from dataclasses import replace

from stages.articulated.attributes import front_panel, measure_handle
from stages.articulated.forward_kinematics import link_frames, measure_closed_box
from stages.articulated.model import JointModel, RobotModel, Role
from stages.contracts.library import Joint

HANDLE_NAMES = ("handle", "knob", "nob", "pull", "grip")


def with_roles(robot: RobotModel) -> RobotModel:
    """The model with roles by type of joint: hinges are doors, slides are drawers.

    A fixed child whose name says so is the handle; else it is looked for on the moving link itself.
    """
    fixed = {joint.child: joint.parent for joint in robot.joints if joint.type == "fixed"}

    def with_role(joint: JointModel) -> JointModel:
        if joint.type == "fixed":
            return joint
        attached = (child for child, parent in fixed.items() if parent == joint.child)
        named = (child for child in attached if any(word in child.lower() for word in HANDLE_NAMES))
        role: Role = "door" if joint.type == "revolute" else "drawer"
        return replace(joint, role=role, handle_link=next(named, joint.child))

    return replace(robot, joints=[with_role(joint) for joint in robot.joints])


def with_roles_of(robot: RobotModel, described: Iterable[Joint]) -> RobotModel:
    """A model with the roles and handles that its `asset.json` gives to its joints, by name."""
    known = {joint.name: joint for joint in described}

    def with_role(joint: JointModel) -> JointModel:
        stated = known.get(joint.name)
        if stated is None:
            return joint
        return replace(joint, role=stated.role, handle_link=stated.handle_link, handle=stated.handle)

    return replace(robot, joints=[with_role(joint) for joint in robot.joints])


def contract_joints(robot: RobotModel) -> list[Joint]:
    """The joints with a role as the contract names them, with what can be measured of their fronts and handles."""
    frames, low = link_frames(robot), measure_closed_box(robot)[0]
    joints = []
    for joint in robot.joints:
        if joint.type == "fixed" or joint.role is None:
            continue
        handle = joint.handle
        if handle is None and joint.handle_link is not None:  # stated, without its kind
            handle = measure_handle(robot, joint, frames)
        joints.append(
            Joint(
                name=joint.name,
                type=joint.type,
                role=joint.role,
                parent=joint.parent,
                link=joint.child,
                axis=tuple(joint.axis.round(9).tolist()),
                lower=round(joint.lower, 5),
                upper=round(joint.upper, 5),
                handle_link=joint.handle_link if handle else None,
                handle=handle,
                panel=front_panel(robot, joint, frames, low),
            )
        )
    return joints


def count_roles(joints: Iterable[Joint], role: Role) -> int:
    """How many of the joints have a role."""
    return sum(joint.role == role for joint in joints)
