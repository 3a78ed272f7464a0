"""Panels on hinges and things that slide, whichever way is up in their file."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from roomkin.stages.articulated.forward_kinematics import link_frames, measure_closed_box
from roomkin.stages.articulated.model import JointModel, Matrix, RobotModel
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.geometry.frames import transform_points

ALONG = 0.9  # cosine: a slide goes along a direction, a panel's hinge across it
MIN_TURN = PARTS["door"].motion[0]  # radians
THIN = 0.6  # thickness of a door, at most, as a share of its width
MIN_OUT = 0.3  # of a slide's way: what leaves its parent's box by less is a sliding door, no drawer
SMALL = 0.05  # of a thing's largest extent: what is smaller, or slides by less, says nothing of it
AT_SIDE = 0.25  # of its width, by which the middle of a panel is away from its hinge at least
MOUTH = 0.2  # of its extent along a slide: the end of a body that something slides out of
ON = 0.5  # of the section of what slides, which this end can take in at least


class Hinge(NamedTuple):
    """A panel that turns about one of its sides, with the names of joint and link.

    along, faces: axes of the root frame (0, 1, 2) that the hinge lies along, and that the panel lies across when it is
    closed. above: it is on the high side of the thing there.
    """

    along: int
    faces: int
    above: bool
    name: str


class Slide(NamedTuple):
    """What slides along an axis of the root frame: out of its body (a drawer), or on what carries it (a lift)."""

    along: int
    drawer: bool


def find_hinges(robot: RobotModel) -> list[Hinge]:
    """The panels of a model that turn; knobs, wheels, levers and seats are none."""
    frames, box = link_frames(robot), measure_closed_box(robot)
    turns = [joint for joint in robot.joints if joint.type == "revolute" and joint.upper - joint.lower > MIN_TURN]
    found = (
        _hinge(joint, seen_points(robot, list_carried_links(joint, robot.joints), frames), frames, box)
        for joint in turns
    )
    return [hinge for hinge in found if hinge is not None]


def _hinge(joint: JointModel, points: Matrix, frames: Mapping[str, Matrix], box: Matrix) -> Hinge | None:
    frame = frames[joint.child]
    axis = frame[:3, :3] @ joint.axis
    along = int(np.argmax(np.abs(axis)))
    if not len(points) or abs(axis[along]) < ALONG:
        return None
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    arm = (middle - frame[:3, 3]) - axis * (axis @ (middle - frame[:3, 3]))  # from the hinge to the middle
    length = max(float(np.linalg.norm(arm)), 1e-9)
    normal = np.cross(axis, arm / length)
    height, width, thickness = (float(np.ptp(points @ way)) for way in (axis, arm / length, normal))
    panel = thickness < THIN * min(height, width) and length > AT_SIDE * width
    if not panel or min(height, width) < SMALL * np.ptp(box, axis=0).max():
        return None
    faces = int(np.argmax(np.where(np.arange(3) == along, 0, np.abs(normal))))
    return Hinge(along, faces, bool(middle[faces] > box.mean(axis=0)[faces]), f"{joint.name} {joint.child}")


def find_slides(robot: RobotModel) -> list[Slide]:
    """What slides out of a body, or stands on what it slides from; sliding doors, levers and buttons do neither."""
    frames, largest = link_frames(robot), float(np.ptp(measure_closed_box(robot), axis=0).max())
    found = []
    for joint in robot.joints:
        axis = frames[joint.child][:3, :3] @ joint.axis
        along, reach = int(np.argmax(np.abs(axis))), joint.upper - joint.lower
        if joint.type != "prismatic" or reach < SMALL * largest or abs(axis[along]) < ALONG:
            continue
        moving = seen_points(robot, list_carried_links(joint, robot.joints), frames)
        body = seen_points(robot, _body_of(joint, robot), frames)
        if not len(moving) or not len(body) or np.delete(np.ptp(moving, axis=0), along).min() < SMALL * largest:
            continue
        ahead = (moving @ axis).max() - (body @ axis).max()
        lift = slides_from_narrower(robot, joint, frames)
        if ahead > 0 if lift else ahead + reach > MIN_OUT * reach:
            found.append(Slide(along, not lift))
    return found


def slides_from_narrower(robot: RobotModel, joint: JointModel, frames: Mapping[str, Matrix]) -> bool:
    """Whether what slides comes from something narrower than itself: a seat on its gas lift, no drawer in its body."""
    axis = frames[joint.child][:3, :3] @ joint.axis
    moving = seen_points(robot, list_carried_links(joint, robot.joints), frames)
    body = seen_points(robot, _body_of(joint, robot), frames)
    if not len(moving) or not len(body):
        return False
    heights, along = body @ axis, int(np.argmax(np.abs(axis)))
    mouth = body[heights >= min((moving @ axis).max(), heights.max()) - MOUTH * np.ptp(heights)]
    sizes, opening = (np.delete(np.ptp(points, axis=0), along) for points in (moving, mouth))
    return bool(np.minimum(sizes, opening).prod() < ON * sizes.prod())


def _body_of(joint: JointModel, robot: RobotModel) -> list[str]:
    """What a joint comes from: the link with all that is fixed to it if something of it is seen, else all the rest."""
    links, fixed = {joint.parent}, [one for one in robot.joints if one.type == "fixed"]
    for one in reversed(fixed):
        links |= {one.parent} if one.child in links else set()
    for one in fixed:
        links |= {one.child} if one.parent in links else set()
    if any(robot.links[link].visuals for link in links):
        return sorted(links)
    return sorted(robot.links.keys() - set(list_carried_links(joint, robot.joints)))


def list_carried_links(joint: JointModel, joints: Iterable[JointModel]) -> list[str]:
    """The link that a joint moves and all links below it in the kinematic tree."""
    links = [joint.child]
    for other in joints:  # parents before children
        if other.parent in links:
            links.append(other.child)
    return links


def seen_points(robot: RobotModel, links: Iterable[str], frames: Mapping[str, Matrix]) -> Matrix:
    """Vertices (N, 3) of what is seen of some links, in the root frame."""
    points = [
        transform_points(frames[link], visual.mesh.vertices) for link in links for visual in robot.links[link].visuals
    ]
    return np.concatenate(points) if points else np.zeros((0, 3))
