"""Joints of a model, whichever way is up: panels on hinges, slides, buttons, and where each is shut."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from roomkin.plugins.importing.sandbox import is_inside, read_inside
from roomkin.stages.articulated.handle import list_moved_links, merge_visuals
from roomkin.stages.articulated.model import JointModel, Matrix, RobotModel, frames_of, link_frames, measure_closed_box
from roomkin.stages.articulated.urdf_tree import THIN
from roomkin.stages.contracts.category import split_words
from roomkin.stages.contracts.files import MAX_TEXT
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.geometry.frames import transform_points

ALONG = 0.9  # cosine: a slide goes along a direction, a panel's hinge across it
MIN_TURN = PARTS["door"].motion[0]  # radians
THIN_LEAF = 0.6  # thickness of a door, at most, as a share of its width
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
    points = (seen_points(robot, list_carried_links(joint, robot.joints), frames) for joint in turns)
    found = (_hinge(joint, seen, frames, box) for joint, seen in zip(turns, points, strict=True))
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
    panel = thickness < THIN_LEAF * min(height, width) and length > AT_SIDE * width
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
    seen = ((frames[link], visual.mesh.vertices) for link in links for visual in robot.links[link].visuals)
    points = [transform_points(frame, vertices) for frame, vertices in seen]
    return np.concatenate(points) if points else np.zeros((0, 3))


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
    span, origin = end - value, joint.origin @ joint.motion(value)
    return replace(joint, origin=origin, axis=np.sign(span) * joint.axis, lower=0.0, upper=abs(span))


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


WORDS = {"button", "buttons", "key", "keys", "switch", "pushbutton"}  # PartNet-Mobility's, of links that are pushed
SEMANTICS = "semantics.txt"  # of PartNet-Mobility: <link> <kind of joint> <what the link is>, a line each
FINGERTIPS = 0.02  # metres across the closed fingers of a Panda: what is smaller is not pushed by itself


def mark_buttons(robot: RobotModel, names: Collection[str] = ()) -> RobotModel:
    """The model with slides as buttons that are called so, or whose joint or link is among `names`."""

    def is_one(joint: JointModel) -> bool:
        said = {*split_words(joint.name), *split_words(joint.child)}
        return bool(said & WORDS) or joint.name in names or joint.child in names

    return replace(
        robot,
        joints=[
            replace(joint, part_type="button") if joint.type == "prismatic" and is_one(joint) else joint
            for joint in robot.joints
        ],
    )


def read_semantics(path: Path, folder: Path) -> set[str]:
    """The links that semantics.txt beside a model's file calls buttons; none if there is no such file."""
    file = path.parent / SEMANTICS
    if not is_inside(file, folder):
        return set()
    lines = [line.split() for line in read_inside(file, folder, MAX_TEXT).decode(errors="replace").splitlines()]
    return {words[0] for words in lines if len(words) == 3 and set(split_words(words[2])) & WORDS}


def explain_unpushable(robot: RobotModel, joint: JointModel, frames: dict[str, Matrix]) -> str:
    """Why what is sprung or called a button is none that a task can push, in metres, all closed; empty: it is one."""
    moved = list_moved_links(joint, robot.joints)
    cap, rest = merge_visuals(robot, moved, frames), merge_visuals(robot, robot.links.keys() - set(moved), frames)
    least, most = PARTS["button"].motion
    travel = joint.upper - joint.lower
    if cap is None or rest is None:
        return f"is sprung or called a button, and is {'not seen' if cap is None else 'on nothing'}"
    if not least <= travel <= most:
        return f"is sprung or called a button, and moves by {100 * travel:.2g} cm"
    axis = frames[joint.child][:3, :3] @ joint.axis
    if (rest.bounds.mean(axis=0) - cap.bounds.mean(axis=0)) @ axis <= 0:
        return "is sprung or called a button, and comes out when it moves"
    across = np.delete(cap.extents, int(np.argmax(np.abs(axis))))
    return f"is a button smaller than {100 * FINGERTIPS:.0f} cm" if across.min() < FINGERTIPS else ""
