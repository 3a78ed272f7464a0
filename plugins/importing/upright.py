"""Which way is up in a model's file: what its hinges, slides, foot and size say, weighed against its format."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from roomkin.plugins.importing.hinges import Hinge, Slide
from roomkin.plugins.importing.importers import Axis
from roomkin.stages.articulated.model import Matrix
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import split_words

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
