"""What an articulation that nobody described is: which way its front faces, which joints are doors or drawers."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stages.articulated.attributes import moved_by
from stages.articulated.forward_kinematics import closed_box, link_frames, visual_bounds
from stages.articulated.model import JointModel, Matrix, RobotModel

ALONG = 0.9  # cosine: a slide goes along a direction, a panel's hinge across it
SHORTEST, LEAST_TURN = 0.05, np.deg2rad(20)  # metres and radians that a drawer or a door moves at least
NARROWEST, LOWEST = 0.06, 0.02  # metres: width and height of the smallest front
THIN = 0.6  # of a door's other horizontal extent: thicker things are no panels


class Front(NamedTuple):
    """A part that a joint moves, as it is closed: where it opens to (an axis of the root frame), area of its face."""

    outward: Matrix
    area: float


def front_direction(robot: RobotModel) -> tuple[Matrix, int] | None:
    """Horizontal axis (a unit vector of the root frame, z up) that most of the fronts face, by area, and how many do.

    A drawer faces where it slides to, a door away from the middle along its thinnest horizontal extent.
    None: no joint tells.
    """
    votes: dict[tuple[float, ...], list[float]] = {}
    for front in _fronts(robot).values():
        votes.setdefault(tuple(front.outward.tolist()), []).append(front.area)
    if not votes:
        return None
    best = max(votes, key=lambda direction: (round(sum(votes[direction]), 6), direction))
    return np.array(best), len(votes[best])


def _fronts(robot: RobotModel) -> dict[str, Front]:
    """By joint, the parts that could be doors or drawers whichever way the model faces."""
    frames, middle = link_frames(robot), closed_box(robot).mean(axis=0)
    moving = [joint for joint in robot.joints if joint.type != "fixed"]
    found = {joint.name: _front(robot, joint, frames, middle) for joint in moving}
    return {name: front for name, front in found.items() if front is not None}


def _front(robot: RobotModel, joint: JointModel, frames: dict[str, Matrix], middle: Matrix) -> Front | None:
    boxes = [visual_bounds(robot.links[link].visuals, frames[link]) for link in moved_by(joint, robot.joints)]
    corners = [box for box in boxes if box is not None]
    if not corners:
        return None  # a helper link
    low, high = np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))
    axis, extents, outward = frames[joint.child][:3, :3] @ joint.axis, high - low, np.zeros(3)
    if joint.type == "prismatic":
        way = int(np.argmax(np.abs(axis)))
        if way == 2 or abs(axis[way]) < ALONG or joint.upper - joint.lower < SHORTEST:
            return None
        outward[way] = np.sign(axis[way])
    else:
        way = int(np.argmin(extents[:2]))
        across = 1 - way
        if joint.upper - joint.lower < LEAST_TURN or abs(axis[way]) > 0.3 or extents[way] > THIN * extents[across]:
            return None  # a stove's knob turns about the direction that it faces
        outward[way] = 1.0 if (low + high)[way] / 2 >= middle[way] else -1.0
    width, height = extents[1 - way], extents[2]
    return None if width < NARROWEST or height < LOWEST else Front(outward, float(width * height))


def doors_and_drawers(robot: RobotModel) -> tuple[RobotModel, list[str]]:
    """The model (z up, front towards +x) with what is neither door nor drawer fixed where it is; a line says so.

    A drawer slides forwards by 5 cm at least, a door hangs on a hinge that lies across the front and turns by at least
    20 degrees; either moves a front of some size. Helper links, a chair's seat, wheels, knobs and buttons are neither.
    """
    joints, fixed, fronts = [], [], _fronts(robot)
    for joint in robot.joints:
        front = fronts.get(joint.name)
        if joint.type != "fixed" and (front is None or (joint.type == "prismatic" and front.outward[0] != 1.0)):
            origin = joint.origin @ joint.motion(joint.lower)
            fixed.append(f"'{joint.name}'")
            joint = replace(joint, type="fixed", origin=origin, lower=0.0, upper=0.0)
        joints.append(joint)
    if not fixed:
        return replace(robot, joints=joints), []
    what = f"joint {fixed[0]} moves" if len(fixed) == 1 else f"joints {', '.join(fixed)} move"
    return replace(robot, joints=joints), [f"{what} no door or drawer: fixed"]
