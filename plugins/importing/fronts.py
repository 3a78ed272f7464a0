"""Find the front of an articulation without annotations, and which of its joints are doors or drawers."""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from roomkin.plugins.importing import hinges
from roomkin.stages.articulated.handle import list_moved_links, merge_visuals
from roomkin.stages.articulated.model import (
    JointModel,
    Matrix,
    RobotModel,
    change_root,
    link_frames,
    measure_closed_box,
)
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.geometry.frames import make_transform, yaw_matrix

SHORTEST = PARTS["drawer"].motion[0]  # metres; and extents of the smallest front
WIDEST = np.deg2rad(200)  # that a door turns: beyond it, nobody has set its limits
ASKEW = np.deg2rad(10)  # by which a front may face another way than along an axis
BEHIND_FRONT = 0.3  # of its parent's extent along a slide: what is as far behind its front when closed is no drawer


class ClosedFront(NamedTuple):
    """A door or drawer, closed: the direction that it opens to (an axis of the root frame) and the area of its face."""

    outward: Matrix
    area: float


def align_to_axes(robot: RobotModel) -> tuple[RobotModel, float]:
    """The model (z up) turned about z by at most 45 degrees, so that most of its faces look along axes; and the angle.

    A model stays as it is without joints, without a common direction of its faces, or if it is askew by less than
    `ASKEW`.
    """
    if all(joint.type == "fixed" for joint in robot.joints):
        return robot, 0.0
    if (shown := merge_visuals(robot, robot.links, link_frames(robot))) is None:
        return robot, 0.0
    normals = shown.face_normals[:, :2]
    weights = shown.area_faces * (np.hypot(*normals.T) > hinges.ALONG)
    total = (weights * np.exp(4j * np.arctan2(normals[:, 1], normals[:, 0]))).sum()
    turn = -float(np.angle(total)) / 4
    if abs(total) < hinges.ALONG * weights.sum() or abs(turn) < ASKEW:
        return robot, 0.0
    return change_root(robot, make_transform(yaw_matrix(turn), np.zeros(3))), turn


def front_direction(robot: RobotModel) -> tuple[Matrix, int] | None:
    """Horizontal axis (a unit vector of the root frame, z up) that most of the fronts face, by area, and how many do.

    A drawer faces where it slides to, a door where it swings to, along its thinnest horizontal extent.
    None: no joint tells.
    """
    votes: dict[tuple[float, ...], list[float]] = {}
    for front in _fronts(_shorten_slides(robot)).values():
        if isinstance(front, ClosedFront):
            votes.setdefault(tuple(front.outward.tolist()), []).append(front.area)
    if not votes:
        return None
    best = max(votes, key=lambda direction: (round(sum(votes[direction]), 6), direction))
    return np.array(best), len(votes[best])


def _fronts(robot: RobotModel) -> dict[str, ClosedFront | str]:
    """For each moving joint its door or drawer, whichever way the model faces, or the reason why it is none."""
    frames = link_frames(robot)
    moving = (joint for joint in robot.joints if joint.type != "fixed" and joint.part_type != "button")
    return {joint.name: _front(robot, joint, frames) for joint in moving}


def _shorten_slides(robot: RobotModel) -> RobotModel:
    """The model with slides that go no farther than all of it is deep, closed: a drawer stays in its body."""
    frames, depths = link_frames(robot), np.ptp(measure_closed_box(robot), axis=0)
    joints = list(robot.joints)
    for index, joint in enumerate(joints):
        most = float(depths[np.argmax(np.abs(frames[joint.child][:3, :3] @ joint.axis))])
        if joint.type == "prismatic" and joint.upper - joint.lower > most:
            joints[index] = replace(joint, upper=joint.lower + most)
    return replace(robot, joints=joints)


def _front(robot: RobotModel, joint: JointModel, frames: dict[str, Matrix]) -> ClosedFront | str:
    links = list_moved_links(joint, robot.joints)
    box = _box(robot, links, frames)
    if box is None:
        return "moves nothing that is seen"
    still = _box(robot, robot.links.keys() - set(hinges.list_carried_links(joint, robot.joints)), frames)
    if still is None:
        return "moves all that is seen"
    low, high = box
    frame = frames[joint.child]
    axis, extents, outward = frame[:3, :3] @ joint.axis, high - low, np.zeros(3)
    if joint.type == "prismatic":
        way = int(np.argmax(np.abs(axis)))
        if way == 2 or abs(axis[way]) < hinges.ALONG:
            return "does not slide along a horizontal axis"
        if joint.upper - joint.lower < SHORTEST:
            return f"slides by less than {100 * SHORTEST:.0f} cm"
        outward[way] = np.sign(axis[way])
        around = _box(robot, [joint.parent], frames)
        if around is not None:
            front, body = ((box @ outward).max() for box in (np.array([low, high]), around))
            reach, depth = joint.upper - joint.lower, np.ptp(around @ outward)
            if front + reach - body < hinges.MIN_OUT * reach or body - front > BEHIND_FRONT * depth:
                return "slides along what it is in"
        if hinges.slides_from_narrower(robot, joint, frames):
            return "slides on something narrower than itself"
    else:
        way = int(np.argmin(extents[:2]))
        across = 1 - way
        if joint.upper - joint.lower < hinges.MIN_TURN:
            return f"turns by less than {np.rad2deg(hinges.MIN_TURN):.0f} degrees"
        if abs(axis[way]) > 0.3 or extents[way] > hinges.THIN_LEAF * extents[across]:
            return "turns no panel about its side"  # a stove's knob turns about the direction that it faces
        center = (low + high) / 2
        swing = float(np.cross(axis, center - frame[:3, 3])[way])
        outward[way] = np.sign(swing)
    width, height = extents[1 - way], extents[2]
    if min(width, height) < SHORTEST:
        return "moves no front of some size"
    if (angle := _measure_skew(robot, links, frames, outward)) > ASKEW:
        return f"stands {np.rad2deg(angle):.0f} degrees askew"
    return ClosedFront(outward, float(width * height))


def _box(robot: RobotModel, links: Iterable[str], frames: dict[str, Matrix]) -> Matrix | None:
    """Box (2, 3) around the visual meshes of some links, closed; None: they have none."""
    points = hinges.seen_points(robot, links, frames)
    return np.array([points.min(axis=0), points.max(axis=0)]) if len(points) else None


def _measure_skew(robot: RobotModel, links: Iterable[str], frames: dict[str, Matrix], outward: Matrix) -> float:
    """Angle in radians between a direction and the median normal, by area, of the front of some links."""
    shown = merge_visuals(robot, links, frames)
    if shown is None:
        return 0.0
    along, aside = shown.face_normals @ outward, shown.face_normals @ np.cross([0, 0, 1], outward)
    facing = (np.hypot(along, aside) > hinges.ALONG) & (along > 0.5)
    angles, areas = np.arctan2(aside, along)[facing], shown.area_faces[facing]
    if not len(angles):
        return 0.0
    order = np.argsort(angles)
    middle = np.searchsorted(np.cumsum(areas[order]), areas.sum() / 2)
    return float(abs(angles[order][min(middle, len(angles) - 1)]))


def doors_and_drawers(robot: RobotModel) -> tuple[RobotModel, list[str]]:
    """The model (z up, front towards +x) with all joints but doors, drawers and buttons fixed; the reasons, in lines.

    A drawer slides forwards by 5 cm at least, out of what it is in, a door swings forwards by 20 degrees at least, on
    a hinge that lies across the front; either moves a front of some size. Helper links, a chair's seat, sliding doors,
    wheels and knobs are neither, and what is said to be a button is no drawer. A drawer slides no farther than all is
    deep.
    """
    joints: list[JointModel] = []
    fixed: dict[str, list[str]] = {}
    lines: list[str] = []
    short = _shorten_slides(robot)
    fronts = _fronts(short)
    frames = link_frames(robot)
    for before, joint in zip(robot.joints, short.joints, strict=True):
        front = fronts.get(joint.name)
        if before.part_type == "button":
            front = hinges.explain_unpushable(robot, before, frames)
            if not front:
                joints.append(before)
                lines.append(f"button '{joint.name}': sprung, and pushed, not pulled")
                continue
        if isinstance(front, ClosedFront) and front.outward[0] != 1.0:
            front = "opens to another side than the front"
        if isinstance(front, str):
            fixed.setdefault(front, []).append(f"'{joint.name}'")
            origin = joint.origin @ joint.motion(joint.lower)
            joint = replace(joint, type="fixed", origin=origin, lower=0.0, upper=0.0)
        elif joint.upper < before.upper:
            reach, depth = (f"{100 * (one.upper - one.lower):.3g} cm" for one in (before, joint))
            lines.append(f"drawer '{joint.name}' slides {reach} in its file, cut to {depth}: all of it is no deeper")
        elif joint.type == "revolute" and joint.upper - joint.lower > WIDEST:
            angle = np.rad2deg(joint.upper - joint.lower)
            lines.append(f"door '{joint.name}' turns by {angle:.0f} degrees: no door does. Set its limits in the file")
        joints.append(joint)
    lines += [f"fixed, as no door or drawer: {', '.join(names)} ({reason})" for reason, names in fixed.items()]
    return replace(robot, joints=joints), lines
