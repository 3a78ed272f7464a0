"""Where a model's doors and drawers are shut: at an end of their limits, or where they are drawn, at 0 between them."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from roomkin.plugins.importing.hinges import list_carried_links, seen_points
from roomkin.stages.articulated.forward_kinematics import frames_of
from roomkin.stages.articulated.model import JointModel, Matrix, RobotModel
from roomkin.stages.articulated.urdf_tree import THIN

SMALLER = 0.9  # share of the boxes' volume, chosen: handles that turn away make less
STEADY = 0.5  # of what the first half of a way makes smaller, what the second does at least: sunk handles make less
FIRST_STEP = {"revolute": np.pi / 4, "prismatic": 0.1}  # radians; of the model's largest extent: shows which way is out

Values = Mapping[str, float]  # positions of joints, by name


def shut_where_smallest(robot: RobotModel) -> RobotModel:
    """The model with every joint shut at its lower limit: where all is smallest, and the part lies along the rest.

    A joint is shut at 0, as it is drawn, if that is between its limits, else at its lower one, unless an end makes all
    much smaller. Of one that is shut at 0 the side stays that swings or slides out. Followers do as what they follow.
    What was changed is in the remarks.
    """
    moving = [one for one in robot.joints if not (one.type == "fixed" or one.follows or one.part_type == "button")]
    usual = {one.name: 0.0 if one.lower < -THIN and one.upper > THIN else one.lower for one in moving}
    shut = usual
    for joint in moving:
        ends = [{**shut, joint.name: end} for end in (joint.lower, joint.upper)]
        smaller = [there for there in ends if _shrinks(robot, joint, shut, there)]
        shut = min(smaller, key=lambda values: _size(robot, values, joint), default=shut)
    joints, remarks, between = list(robot.joints), [], []
    for joint in moving:
        at, end = shut[joint.name], joint.lower
        if at == joint.lower:
            continue
        if at == joint.upper:
            where = f"at {at:.3g}, where the model is smallest, not at {usual[joint.name]:.3g}"
            remarks.append(f"'{joint.name}' is taken to be shut {where}")
        else:
            end = _find_open_end(robot, joint, shut)
            between.append(f"'{joint.name}' ({joint.lower:.3g} to {joint.upper:.3g}) opens to {end:.3g}")
        joints = [_shut_at(one, at, end) if joint.name in (one.name, one.follows) else one for one in joints]
    if between:
        remarks.append(f"taken to be shut at 0, between their limits, as drawn: {', '.join(between)}")
    return replace(robot, joints=joints, remarks=(*robot.remarks, *remarks)) if remarks else robot


def _shrinks(robot: RobotModel, joint: JointModel, here: Values, there: Values) -> bool:
    """Whether a joint's way makes the model much smaller, up to its end."""
    halfway = {**here, joint.name: (here[joint.name] + there[joint.name]) / 2}
    first, middle, last = (_volume(robot, values) for values in (here, halfway, there))
    steady = middle - last > STEADY * (first - middle)
    return steady and _size(robot, there, joint) < SMALLER * _size(robot, here, joint)


def _find_open_end(robot: RobotModel, joint: JointModel, shut: Values) -> float:
    """The limit on the side where a joint that is shut at 0 comes out of the rest; the farther one if both do."""
    unit = 1.0 if joint.type == "revolute" else float(np.ptp(_points(robot, shut, robot.links), axis=0).max())
    step = min(-joint.lower, joint.upper, FIRST_STEP[joint.type] * unit)
    sizes = {end: _volume(robot, {**shut, joint.name: np.sign(end) * step}) for end in (joint.lower, joint.upper)}
    return max(sizes, key=lambda end: (round(sizes[end] / max(sizes.values()), 6), abs(end), end))


def _shut_at(joint: JointModel, value: float, end: float) -> JointModel:
    """The same joint, shut at 0, which was `value`, and open at what was `end`."""
    span = end - value
    return replace(
        joint, origin=joint.origin @ joint.motion(value), axis=np.sign(span) * joint.axis, lower=0.0, upper=abs(span)
    )


def _size(robot: RobotModel, values: Values, joint: JointModel) -> float:
    """Volume of the box around all, and of that around what a joint carries, which is least when it lies along it."""
    return _volume(robot, values) + _volume(robot, values, list_carried_links(joint, robot.joints))


def _volume(robot: RobotModel, values: Values, links: Iterable[str] | None = None) -> float:
    """Volume of the box around what is seen of some links, of all by default; 0 if that is nothing."""
    points = _points(robot, values, robot.links if links is None else links)
    return float(np.prod(np.ptp(points, axis=0))) if len(points) else 0.0


def _points(robot: RobotModel, values: Values, links: Iterable[str]) -> Matrix:
    """What is seen of some links, in the root frame, with the joints at these positions."""
    joints = [replace(one, lower=values.get(one.follows or one.name, one.lower)) for one in robot.joints]
    return seen_points(robot, links, frames_of(robot.root, joints))
