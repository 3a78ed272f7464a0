"""Up axis, unit and front of the files of a folder: evidence from each model, and what most of them agree on."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from stages.articulated.forward_kinematics import closed_box, link_frames
from stages.articulated.model import Matrix, RobotModel
from stages.articulated.sense import ALONG, LEAST_TURN, SHORTEST, front_direction, squared
from stages.assets.importers import Axis, Importer
from stages.assets.imports import in_file, standing, usual_front
from stages.contracts.files import Contract
from stages.procedural.sizes import usual

T = TypeVar("T")
UNITS = {1.0: "metres", 0.01: "centimetres", 0.001: "millimetres", 0.0254: "inches"}
UPS: tuple[Axis, Axis] = ("+y", "+z")  # directions that files call up
MAJORITY = 3  # models that say the same, at least, and times as many of them as say otherwise
ORIGIN = 0.01  # of its height, by which the foot of what stands may miss the origin's height


class Shared(Contract):
    """What nearly all the models of a kind of file that tell it have in common; None: each by itself."""

    up: Axis | None = None
    unit: float | None = None  # metres
    front: Axis | None = None


class Evidence(Contract):
    """What a model tells of its file.

    extents: (3,) in its frame and unit. slides: the direction up if its drawers slide level. up: that, or the direction
    in which its doors hang upright and its foot is at the origin's height. fronts: by up, where its doors and drawers
    open to.
    """

    extents: tuple[float, float, float]
    slides: Axis | None = None
    up: Axis | None = None
    fronts: dict[Axis, Axis] = {}

    def unit(self, category: str, up: Axis) -> float | None:
        """Metres per unit in which it is as large as its category usually is; None: in none, or that is not known."""
        sizes, size = usual(category), self.standing(up)
        return next((unit for unit in UNITS if sizes is not None and sizes.misfit(size * unit) == 0), None)

    def standing(self, up: Axis) -> Matrix:
        """Its extents (3,), the height last."""
        height = "xyz".index(up[1])
        return np.array([*np.delete(self.extents, height), self.extents[height]])


def evidence(robot: RobotModel) -> Evidence:
    """The evidence of a model, in its file's frame."""
    box, frames = closed_box(robot), link_frames(robot)
    slides, hinges = (_of_joints(robot, frames, kind) for kind in ("prismatic", "revolute"))
    grounded = [up for up in UPS if abs(box[0, "xyz".index(up[1])]) < ORIGIN * np.ptp(box, axis=0)["xyz".index(up[1])]]
    foot = grounded[0] if len(grounded) == 1 else None
    fronts: dict[Axis, Axis] = {}
    for up in UPS:
        if (told := front_direction(squared(standing(robot, up, usual_front(up)))[0])) is not None:
            fronts[up] = in_file(told[0], usual_front(up), up)
    return Evidence(
        extents=tuple(np.ptp(box, axis=0).tolist()),
        slides=slides,
        up=slides or (foot if hinges in (None, foot) else None),
        fronts=fronts,
    )


def _of_joints(robot: RobotModel, frames: Mapping[str, Matrix], kind: str) -> Axis | None:
    """The direction up by the axes of its slides, which are level, or hinges, most of which are upright."""
    least = SHORTEST * float(np.ptp(closed_box(robot), axis=0).max()) if kind == "prismatic" else LEAST_TURN
    axes = [
        np.abs(frames[joint.child][:3, :3] @ joint.axis)
        for joint in robot.joints
        if joint.type == kind and joint.upper - joint.lower > least
    ]
    y, z = (sum(axis[number] > ALONG for axis in axes) for number in (1, 2))
    if y == z:
        return None
    return "+y" if (y > z) == (kind == "revolute") else "+z"


class Told(NamedTuple):
    """A model that was read: the kind of its file, its category, and what it tells."""

    kind: str
    category: str
    evidence: Evidence


def shared(models: Iterable[Told], kinds: Mapping[str, Importer]) -> tuple[dict[str, Shared], dict[str, str]]:
    """What the models of each kind of file share, by suffix; and how many tell it, in words."""
    groups: dict[str, list[Told]] = {}
    for model in models:
        groups.setdefault(model.kind, []).append(model)
    common, words = {}, {}
    for kind, group in sorted(groups.items()):
        ups = [one.evidence.up for one in group if one.evidence.up]
        up = _most(ups)
        by_up = up or kinds[kind].up
        units = [unit for one in group if (unit := one.evidence.unit(one.category, by_up))]
        fronts = [front for one in group if (front := one.evidence.fronts.get(by_up))]
        common[kind] = Shared(up=up, unit=_most(units), front=_most(fronts))
        told = (f"up: {_counts(ups)}", f"unit: {_counts([UNITS[unit] for unit in units])}", f"front: {_counts(fronts)}")
        words[kind] = f"{len(group)} models; {'; '.join(told)}"
    return common, words


def _counts(told: Sequence[str]) -> str:
    """How many say what, the most first."""
    return ", ".join(f"{count} {value}" for value, count in Counter(told).most_common()) or "none tells"


def _most(told: Sequence[T]) -> T | None:
    """What most of them say; None: they are too few, or do not agree."""
    for value, count in Counter(told).most_common(1):
        if count >= MAJORITY * max(1, len(told) - count):
            return value
    return None
