"""Up axis, unit and front of files as most of them say, and pack.yaml, where the user corrects what all share."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
import yaml
from pydantic import ValidationError

from roomkin.plugins.importing.fronts import align_to_axes, front_direction
from roomkin.plugins.importing.hinges import Hinge, Slide, find_hinges, find_slides
from roomkin.plugins.importing.importers import Axis, Importer
from roomkin.plugins.importing.imports import guess_front, in_file, turn_to_axes
from roomkin.plugins.importing.proposal import ProposedFile
from roomkin.plugins.importing.single_body import find_ground
from roomkin.stages.articulated.model import Matrix, RobotModel, measure_closed_box
from roomkin.stages.contracts.categories import find_usual_size, known_categories
from roomkin.stages.contracts.category import split_words
from roomkin.stages.contracts.errors import InputError, fault_of, line_of
from roomkin.stages.contracts.files import Contract, read_text, write_text

UPS: tuple[Axis, ...] = ("+z", "+y", "+x")
COMMON: tuple[Axis, ...] = ("+z", "+y")  # directions that kinds of files without an agreed one call up
LIDS = {"cover", "lid", "screen", "seat"}  # words that call a panel no door, and no lid
DOORS = {"door", "doors"}

# Logarithms of odds that files are so.
FORMAT = 2.5  # up is what the format says
SELDOM = 3.5  # it is no direction of `COMMON`
FOOT = 2.0  # the foot of what stands is at the origin's height
FITS = 1.5  # a thing is as large as its category
CLEAR = 1.0  # lead of a direction over the next that decides
# Shares.
NAMED = 0.05  # of panels that are called doors and are lids, or the other way round; of lids that are below
DRAWER, LIFT = 0.02, 0.9  # of what slides like a drawer, or like a seat on its gas lift: along the direction up


class Up(NamedTuple):
    """The direction up.

    ahead: by how much it is likelier than the next one, logarithm of odds. because: what speaks more for it than for
    the format's direction; doubt: what speaks as much for another than for the format's, if it is that one; words.
    """

    axis: Axis
    ahead: float
    because: str
    doubt: str


def weigh_hinges(hinges: Iterable[Hinge], category: str | None) -> Matrix:
    """(3,) logarithms of likelihoods of `UPS`: as doors, flaps and lids are frequent in the category."""
    known = known_categories().get(category or "")
    doors, flaps = (known.doors, known.flaps) if known else (0, 0)
    usual = np.array([doors + 1, flaps + 1, 1, NAMED]) / (doors + flaps + 3)
    shares = [[_share(hinge, up, usual) for up in UPS] for hinge in hinges]
    return np.log(np.mean(shares, axis=0)) if shares else np.zeros(3)


def _share(hinge: Hinge, up: Axis, usual: Matrix) -> float:
    height, called = number(up), set(split_words(hinge.name))
    if height == hinge.along:
        return float(usual[0]) * (NAMED if called & LIDS and not called & DOORS else 1.0)
    if height != hinge.faces:
        return float(usual[1])
    return float(usual[2 if hinge.above else 3]) * (NAMED if called & DOORS else 1.0)


def weigh_slides(slides: Iterable[Slide]) -> Matrix:
    """(3,) logarithms of likelihoods of `UPS`: drawers slide level, what stands on a gas lift slides up."""
    along = [[(slide.along == number(up), DRAWER if slide.drawer else LIFT) for up in UPS] for slide in slides]
    shares = [[share if it else 1 - share for it, share in row] for row in along]
    return np.log(np.mean(shares, axis=0)) if shares else np.zeros(3)


def choose_up(says: Mapping[str, Matrix], agreed: Axis | None, sure: bool) -> Up:
    """The direction up that kinds of evidence, logarithms of likelihoods (3,) of `UPS`, speak for.

    Args:
        agreed: direction up of such files. sure: whether nearly all of them keep to it.
    """
    speaks = np.sum(list(says.values()), axis=0)
    usual = [0 if up == agreed else -SELDOM if up not in COMMON else -FORMAT if sure else 0 for up in UPS]
    total = (speaks + usual).round(6)
    first, second = sorted(range(len(UPS)), key=lambda k: (-total[k], UPS[k] != agreed))[:2]
    best = max(COMMON, key=lambda up: speaks[UPS.index(up)])
    ahead = float(total[first] - total[second])
    if agreed is None or UPS[first] != agreed:
        return Up(UPS[first], ahead, _words(says, UPS[first], agreed), "")
    clear = speaks[UPS.index(best)] - speaks[first] >= CLEAR
    return Up(agreed, ahead, "", f"its {_words(says, best, agreed)} would have {best}" if clear else "")


def _words(says: Mapping[str, Matrix], up: Axis, agreed: Axis | None) -> str:
    """The kinds of evidence that speak more for one direction than for that of the format."""
    here, there = UPS.index(up), UPS.index(agreed or up)
    return " and ".join(name for name, values in says.items() if values[here] > values[there])


def number(axis: Axis) -> int:
    """0, 1 or 2 of an axis."""
    return "xyz".index(axis[1])


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


HEAD = """\
# What the models share; change it and run import again. null: each model by itself.
# up, front: an axis of their files; unit: metres. categories: what names say, and what that is here.
"""


class Pack(ProposedFile):
    """By suffix, what the models of a kind of file share; and the category for what their names say."""

    kinds: dict[str, Shared] = {}
    categories: dict[str, str] = {}


def read_pack(path: Path) -> Pack:
    """The file, or nothing if there is none.

    Raises:
        InputError: it is broken.
    """
    if not path.is_file():
        return Pack()
    try:
        return Pack.model_validate(yaml.safe_load(read_text(path, "or delete it")) or {})
    except ValidationError as error:
        first = error.errors()[0]
        what = f"{'.'.join(map(str, first['loc']))}: {first['msg']}."
        raise InputError(path, what, "or delete it", code="E-PACK-BROKEN") from None
    except yaml.YAMLError as error:
        where, what = line_of(path, error), f"is no YAML: {fault_of(error)}."
        raise InputError(where, what, "or delete it", code="E-PACK-BROKEN") from None


def complete_pack(pack: Pack, proposed: Mapping[str, Shared], categories: Iterable[str]) -> Pack:
    """The pack, completed. What a person wrote in it counts."""
    pack = pack if pack.by_hand else Pack()
    stated = {category: category for category in sorted(set(categories))}
    whole = Pack(kinds={**proposed, **pack.kinds}, categories={**stated, **pack.categories})
    return whole if pack != Pack() else whole.add_checksum()


def write_pack(path: Path, pack: Pack, counts: Mapping[str, str]) -> None:
    """Write the file; `counts`: by suffix, how many models tell what."""
    lines = [HEAD + "kinds:"]
    for kind, shared in pack.kinds.items():
        lines += [f"  # {counts[kind]}"] if kind in counts else []
        values = yaml.safe_dump(shared.model_dump(), default_flow_style=True, sort_keys=False, width=1000)
        lines.append(f"  {kind}: {values.strip()}")
    lines.append("categories:" if pack.categories else "categories: {}")
    for name, category in pack.categories.items():
        entry = yaml.safe_dump({name: category}, width=1000).strip()
        lines.append(f"  {entry}{'' if category in known_categories() else '  # none of ours'}")
    lines += [f"guess: {pack.guess}"] if pack.guess else []
    write_text(path, "\n".join(lines) + "\n")
