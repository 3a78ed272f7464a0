"""Push buttons of imported models: slides of which a spring, a name or PartNet-Mobility's semantics.txt says so."""

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from roomkin.plugins.importing.inside import is_inside, read_inside
from roomkin.stages.articulated.attributes import list_moved_links, merge_visuals
from roomkin.stages.articulated.model import JointModel, Matrix, RobotModel
from roomkin.stages.contracts.category import split_words
from roomkin.stages.contracts.files import MAX_TEXT
from roomkin.stages.contracts.parts import PARTS

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
    """Why a slide that is sprung or called a button is none that a task can push; empty: it is one.

    Args:
        frames: of the links in metres, everything closed.
    """
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
