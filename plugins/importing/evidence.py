"""Up axis, unit and front of the files of a folder: evidence from each model, and what most of them agree on."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

import numpy as np

from roomkin.plugins.importing.fronts import align_to_axes, front_direction
from roomkin.plugins.importing.hinges import Hinge, Slide, find_hinges, find_slides
from roomkin.plugins.importing.importers import Axis, Importer
from roomkin.plugins.importing.imports import guess_front, in_file, turn_to_axes
from roomkin.plugins.importing.single_body import find_ground
from roomkin.plugins.importing.upright import CLEAR, FITS, FOOT, UPS, Up, choose_up, number, weigh_hinges, weigh_slides
from roomkin.stages.articulated.forward_kinematics import measure_closed_box
from roomkin.stages.articulated.model import Matrix, RobotModel
from roomkin.stages.contracts.categories import find_usual_size
from roomkin.stages.contracts.files import Contract

T = TypeVar("T")
UNITS = {1.0: "metres", 0.01: "centimetres", 0.001: "millimetres", 0.0254: "inches"}
SMALLER = (0.001, 0.01, 0.0254)
MAJORITY = 3  # models that say the same, at least, and times as many of them as say otherwise
ORIGIN = 0.01  # of its height, by which the foot of what stands may miss the origin's height


class Shared(Contract):
    """What nearly all models of a kind of file have in common, among those that show it; None: it is set model by
    model."""

    up: Axis | None = None
    unit: float | None = None  # metres
    front: Axis | None = None


class Evidence(Contract):
    """The evidence of a model about its file: up, unit and front.

    extents: (3,) in its frame and unit. hinges, slides: of it. foot: the direction in which alone its foot is at the
    origin's height. fronts: by up, where its doors and drawers open to. grounds: by up, the node that is a ground under
    the rest. remarks: what its reader left out.
    """

    extents: tuple[float, float, float]
    hinges: tuple[Hinge, ...] = ()
    slides: tuple[Slide, ...] = ()
    foot: Axis | None = None
    fronts: dict[Axis, Axis] = {}
    grounds: dict[Axis, str] = {}
    remarks: tuple[str, ...] = ()

    def find_up(self, category: str, agreed: Axis | None = None, sure: bool = False) -> Up:
        """The direction up, if such files agree on one: all but exceptions (`sure`), or many of them.

        A direction outside of `UPS`, from a user's own importer, stays: there is no evidence about it.
        """
        if agreed is not None and agreed not in UPS:
            return Up(agreed, 0.0, "", "")
        says = {
            "hinges": weigh_hinges(self.hinges, category),
            "slides": weigh_slides(self.slides),
            "foot": FOOT * np.array([up == self.foot for up in UPS]),
            "size": FITS * np.array([self.unit(category, up) is not None for up in UPS]),
        }
        return choose_up(says, agreed, sure)

    def unit(self, category: str, up: Axis) -> float | None:
        """Metres per unit that give the model its category's usual size; None: no unit does, or no size is known."""
        sizes, size = find_usual_size(category), self.order_extents(up)
        return next((unit for unit in UNITS if sizes is not None and sizes.misfit(size * unit) == 0), None)

    def find_unit(self, category: str, up: Axis) -> float:
        """Metres per unit of a model that would be absurd in metres: the unit that brings it nearest to its
        category's usual size, else a millimetre."""
        sizes, size = find_usual_size(category), self.order_extents(up)
        return min(SMALLER, key=lambda unit: sizes.misfit(size * unit) if sizes else 0.0)

    def order_extents(self, up: Axis) -> Matrix:
        """Its extents (3,), the height last."""
        height = "xyz".index(up[1])
        return np.array([*np.delete(self.extents, height), self.extents[height]])


def collect_evidence(robot: RobotModel) -> Evidence:
    """The evidence of a model, in its file's frame."""
    box = measure_closed_box(robot)
    extents = np.ptp(box, axis=0)
    grounded = [up for up in UPS if abs(box[0, number(up)]) < ORIGIN * extents[number(up)]]
    fronts: dict[Axis, Axis] = {}
    for up in UPS:
        if (facing := front_direction(align_to_axes(turn_to_axes(robot, up, guess_front(up)))[0])) is not None:
            fronts[up] = in_file(facing[0], guess_front(up), up)
    return Evidence(
        extents=tuple(extents.tolist()),
        hinges=tuple(find_hinges(robot)),
        slides=tuple(find_slides(robot)),
        foot=grounded[0] if len(grounded) == 1 else None,
        fronts=fronts,
        grounds={up: name for up in UPS if (name := find_ground(robot, number(up)))},
        remarks=robot.remarks,
    )


def find_shared_facts(
    models: Iterable[tuple[str, str, Evidence]], kinds: Mapping[str, Importer]
) -> tuple[dict[str, Shared], dict[str, str]]:
    """The facts that models (suffix, category, evidence) of each kind of file share, by suffix; and how many models
    support them, in words."""
    groups: dict[str, list[tuple[str, Evidence]]] = {}
    for kind, category, evidence in models:
        groups.setdefault(kind, []).append((category, evidence))
    common, words = {}, {}
    for kind, group in sorted(groups.items()):
        directions = [evidence.find_up(category) for category, evidence in group]
        ups = [direction.axis for direction in directions if direction.ahead >= CLEAR]
        up = _find_majority(ups)
        by_up = up or kinds[kind].up
        units = [unit for category, evidence in group if (unit := evidence.unit(category, by_up))]
        fronts = [front for _, evidence in group if (front := evidence.fronts.get(by_up))]
        common[kind] = Shared(up=up, unit=_find_majority(units), front=_find_majority(fronts))
        names = _count_values([UNITS[unit] for unit in units])
        words[kind] = f"{len(group)} models; up: {_count_values(ups)}; unit: {names}; front: {_count_values(fronts)}"
    return common, words


def _count_values(values: Sequence[str]) -> str:
    """The values with how often each occurs, the most frequent first."""
    return ", ".join(f"{count} {value}" for value, count in Counter(values).most_common()) or "none tells"


def _find_majority(values: Sequence[T]) -> T | None:
    """The value that most of them share; None: they are too few, or do not agree."""
    for value, count in Counter(values).most_common(1):
        if count >= MAJORITY * max(1, len(values) - count):
            return value
    return None
