"""What the models of a folder share: direction up, unit and front, by what most of those that tell it say."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from stages.articulated.forward_kinematics import closed_box, link_frames
from stages.articulated.model import Matrix, RobotModel
from stages.articulated.sense import ALONG, LEAST_TURN, SHORTEST, front_direction, squared
from stages.assets.facing import front_before_back
from stages.assets.importers import Axis, Importer
from stages.assets.imports import in_file, standing
from stages.assets.proportions import UNITS, UPS, leaning, other_up, unit_told
from stages.contracts.files import Contract

T = TypeVar("T")
LEAST, MAJORITY = 3, 3.0  # models that tell, and how many times more of them must say one thing than all others


class Shared(Contract):
    """What nearly all the models of a kind of file have in common that tell it; None: each by itself."""

    up: Axis | None = None
    unit: float | None = None  # metres
    front: Axis | None = None


NOTHING = Shared()


class Evidence(Contract):
    """What a model tells of its file.

    extents: (3,) in its frame and unit. slides, hinges, stands: the direction up if drawers slide level, doors hang
    upright, or it stands on its foot. fronts: by up, where its doors and drawers open to, or away from its back.
    """

    extents: tuple[float, float, float]
    slides: Axis | None = None
    hinges: Axis | None = None
    stands: Axis | None = None
    fronts: dict[Axis, Axis] = {}

    @property
    def up(self) -> Axis | None:
        """The direction up that it tells: a flap's hinge is level, so hinges count only if nothing says otherwise."""
        if self.slides is not None:
            return self.slides
        return self.stands if self.hinges in (None, self.stands) else None


def evidence(robot: RobotModel, category: str) -> Evidence:
    """What a model tells, in its file's frame."""
    low, high = closed_box(robot)
    frames = link_frames(robot)
    points = np.concatenate(
        [visual.moved(frames[link.name]).mesh.vertices for link in robot.links.values() for visual in link.visuals]
    )
    fronts: dict[Axis, Axis] = {}
    for up in UPS:
        stood = squared(standing(robot, up))[0]
        told, backed = front_direction(stood), front_before_back(stood, category)
        if (front := told[0] if told is not None else backed) is not None:
            fronts[up] = in_file(front, "+z" if up == "+y" else "+x", up)
    return Evidence(
        extents=tuple((high - low).tolist()),
        slides=_of_joints(robot, frames, "prismatic"),
        hinges=_of_joints(robot, frames, "revolute"),
        stands=leaning(points),
        fronts=fronts,
    )


def _of_joints(robot: RobotModel, frames: Mapping[str, Matrix], kind: str) -> Axis | None:
    """The direction up by the axes of its slides, which are level, or hinges, most of which are upright."""
    least = SHORTEST * float(np.ptp(closed_box(robot), axis=0).max()) if kind == "prismatic" else LEAST_TURN
    axes = [
        frames[joint.child][:3, :3] @ joint.axis
        for joint in robot.joints
        if joint.type == kind and joint.upper - joint.lower > least
    ]
    along = {up: sum(abs(axis["xyz".index(up[1])]) > ALONG for axis in axes) for up in UPS}
    if along["+y"] == along["+z"]:
        return None
    most: Axis = "+y" if along["+y"] > along["+z"] else "+z"
    return most if kind == "revolute" else other_up(most)


class Told(NamedTuple):
    """A model that was read: the kind of its file, its category, and what it tells."""

    kind: str
    category: str
    evidence: Evidence


def shared(models: Iterable[Told], kinds: Mapping[str, Importer]) -> tuple[dict[str, Shared], dict[str, str]]:
    """What the models of each kind share, by suffix; and how many tell it, in words."""
    groups: dict[str, list[Told]] = {}
    for model in models:
        groups.setdefault(model.kind, []).append(model)
    common, words = {}, {}
    for kind, group in sorted(groups.items()):
        ups = [told for one in group if (told := one.evidence.up)]
        up, agreed = _most(ups), kinds[kind].up
        tried = [up] if up else [agreed, other_up(agreed)]
        units = [unit_told(np.array(one.evidence.extents), one.category, tried) for one in group]
        told_units = [unit for unit in units if unit is not None]
        unit = _most(told_units)
        fronts = [told for one in group if (told := one.evidence.fronts.get(up or agreed))]
        common[kind] = Shared(up=up, unit=unit, front=_most(fronts))
        words[kind] = (
            f"{len(group)} models; up: {_counts(ups)}; unit: {_counts([UNITS[told] for told in told_units])}; "
            f"front: {_counts(fronts)}"
        )
    return common, words


def _counts(told: Sequence[str]) -> str:
    """How many say what, the most first."""
    return ", ".join(f"{count} {value}" for value, count in Counter(told).most_common()) or "none tells"


def _most(told: Sequence[T]) -> T | None:
    """What most of them say; None: they are too few, or do not agree."""
    for value, count in Counter(told).most_common(1):
        if count >= max(LEAST, MAJORITY * (len(told) - count)):
            return value
    return None
