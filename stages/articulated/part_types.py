"""Part types of joints: doors, drawers and buttons, with their handles."""

from collections.abc import Iterable
from dataclasses import replace

from roomkin.stages.articulated.attributes import front_panel, measure_handle
from roomkin.stages.articulated.forward_kinematics import link_frames, measure_closed_box
from roomkin.stages.articulated.model import JointModel, RobotModel
from roomkin.stages.contracts.library import Joint
from roomkin.stages.contracts.parts import FRONTS, PARTS, PartType

HANDLE_NAMES = ("handle", "knob", "nob", "pull", "grip")


def assign_part_types(robot: RobotModel) -> RobotModel:
    """The model with the part type of every moving joint: as its reader says, else the front with such a joint.

    A fixed child whose name says so is the handle; else it is looked for on the moving link itself. A button is pushed
    at its face.
    """
    fixed = {joint.child: joint.parent for joint in robot.joints if joint.type == "fixed"}

    def assign(joint: JointModel) -> JointModel:
        if joint.type == "fixed":
            return joint
        if joint.part_type == "button":
            return replace(joint, handle_link=joint.child, handle="face")
        attached = (child for child, parent in fixed.items() if parent == joint.child)
        named = (child for child in attached if any(word in child.lower() for word in HANDLE_NAMES))
        part = next(front for front in FRONTS if PARTS[front].joint == joint.type)
        return replace(joint, part_type=part, handle_link=next(named, joint.child))

    return replace(robot, joints=[assign(joint) for joint in robot.joints])


def copy_part_types(robot: RobotModel, described: Iterable[Joint]) -> RobotModel:
    """A model with the part types and handles that its `asset.json` gives to its joints, by name."""
    known = {joint.name: joint for joint in described}

    def copy(joint: JointModel) -> JointModel:
        stated = known.get(joint.name)
        if stated is None:
            return joint
        return replace(joint, part_type=stated.part_type, handle_link=stated.handle_link, handle=stated.handle)

    return replace(robot, joints=[copy(joint) for joint in robot.joints])


def contract_joints(robot: RobotModel) -> list[Joint]:
    """The joints with a part type as the contract names them, with what can be measured of fronts and handles."""
    frames, low = link_frames(robot), measure_closed_box(robot)[0]
    joints = []
    for joint in robot.joints:
        if joint.type == "fixed" or joint.part_type is None:
            continue
        handle = joint.handle
        if handle is None and joint.handle_link is not None:  # stated, without its kind
            handle = measure_handle(robot, joint, frames)
        joints.append(
            Joint(
                name=joint.name,
                type=joint.type,
                part_type=joint.part_type,
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


def count_parts(joints: Iterable[Joint], part: PartType) -> int:
    """How many of the joints have a part type."""
    return sum(joint.part_type == part for joint in joints)
