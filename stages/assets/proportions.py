"""Unit and up of a model that does not tell, from the sizes that its category has in our library."""

from collections.abc import Sequence
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np

from stages.articulated.model import Matrix
from stages.assets.importers import Axis
from stages.procedural.catalogue import CATEGORIES, sample

UNITS = {1.0: "metres", 0.01: "centimetres", 0.001: "millimetres", 0.0254: "inches"}
SAMPLES = 8  # models of a category that say how large it is
SPREAD = np.log(1.5)  # beyond the sizes seen that is still usual
UNLIKELY = np.log(1.5)  # sum over three extents of how far beyond they are
LYING = np.log(1.1)  # the same, for another side to be tried as the bottom
HOPELESS = np.log(3.0)  # the same: what is as far beyond in every unit is in none
FAR = np.log(9.0)  # the same: what is as far beyond in the unit of the others of its folder is in another
BETTER = 3.0  # times less must it be for another guess
BOTTOM, FOOT = 0.005, 0.2  # share of the height that is the bottom; of width and depth that it has at least
HUNG = {"clock", "mirror", "picture", "wall_cabinet", "wall_shelf"}  # which need not stand
ORIGIN = 0.01  # of its height, by which the lowest point may miss the origin's
UPS: tuple[Axis, Axis] = ("+y", "+z")
SPHERE = 0.1  # of its radius, by which a model may miss it
SMALLEST, LARGEST = 0.01, 20.0  # metres: no furniture is larger than a room
LARGEST_THING = 5.0  # metres: what is larger, in a category that is not known, is not in metres


class Usual(NamedTuple):
    """Logarithms of the least and the largest extents of a category: ground plan's shorter, its longer, height."""

    low: Matrix
    high: Matrix

    def misfit(self, plan: Matrix, height: float) -> float:
        """How far extents in metres lie beyond."""
        extents = np.log([*np.sort(plan), height])
        return float(np.maximum(0, np.maximum(self.low - SPREAD - extents, extents - self.high - SPREAD)).sum())

    def factor(self, plan: Matrix, height: float) -> float:
        """What would make it as large as usual, two digits."""
        extents = np.log([*np.sort(plan), height])
        return float(f"{np.exp(np.mean((self.low + self.high) / 2 - extents)):.2g}")

    def __str__(self) -> str:
        low, high = np.exp(self.low) * 100, np.exp(self.high) * 100
        (a, b, c), (d, e, f) = low.round().astype(int), high.round().astype(int)
        return f"{a} to {d} by {b} to {e} cm, {c} to {f} cm high"


@cache
def sizes_of(category: str) -> Matrix:
    """Depth, width and height (N, 3) of the first models of a category of ours, metres; (0, 3): there is no such."""
    count = SAMPLES if category in CATEGORIES else 0
    sizes = [sample(category, k, 0).parameters["size"] for k in range(count)]
    return np.array(sizes, dtype=float).reshape(-1, 3)


def usual(category: str) -> Usual | None:
    """The sizes of a category of ours; None: there is no such category."""
    sizes = sizes_of(category)
    if not len(sizes):
        return None
    extents = _logarithms(sizes)
    return Usual(extents.min(axis=0), extents.max(axis=0))


def unusual(category: str | None, size: Matrix) -> str:
    """What is odd about extents (depth, width, height), metres, of a thing of a category of ours; empty: nothing.

    Which of depth and width is which does not matter.
    """
    known = usual(category or "")
    if known is None or known.misfit(size[:2], float(size[2])) == 0:
        return ""
    shorter, longer = np.sort(size[:2])
    return f"is {100 * shorter:.0f} by {100 * longer:.0f} cm, {100 * size[2]:.0f} cm high; usual are {known}"


def likest(extents: Matrix, categories: Sequence[str]) -> str:
    """Of some categories of ours the one that has such proportions (3,), whatever the size; of several the first."""

    def misfit(category: str) -> float:
        shapes = _shapes(sizes_of(category))
        own = _shapes(np.maximum(extents, 1e-9)[None])[0]
        return float(np.maximum(0, np.maximum(shapes.min(axis=0) - own, own - shapes.max(axis=0))).sum().round(6))

    return min(categories, key=misfit)


def _logarithms(sizes: Matrix) -> Matrix:
    """(N, 3) of ground plan's shorter and longer extent and height."""
    return np.asarray(np.log(np.c_[np.sort(sizes[:, :2], axis=1), sizes[:, 2]]))


def _shapes(sizes: Matrix) -> Matrix:
    """The same whatever the size."""
    extents = _logarithms(sizes)
    return np.asarray(extents - extents.mean(axis=1, keepdims=True))


def up_and_unit(
    extents: Matrix, category: str, ups: Sequence[Axis], in_metres: bool = False, unit: float | None = None
) -> tuple[Axis, float]:
    """Direction up and metres per unit of a model with these extents (3,) in its file.

    Another than the first (and metres) only if the extents are unlike any in the category and then fit far better.
    Where no unit does and the kind of file is in none, it is what makes the model as large as usual, as long as
    its proportions are usual.

    Args:
        extents: in units.
        category: of the model.
        ups: directions up that it may have, the likeliest first.
        in_metres: whether its kind of file is in metres: then only a category of ours tells another unit.
        unit: that others of its folder have; it counts unless the model would be far from usual, a speck or a house.
    """
    sizes = usual(category)
    if unit is not None and not SMALLEST <= extents.max() * unit <= LARGEST:
        unit = None
    if sizes is None:
        fitting = (unit for unit in UNITS if float(extents.max()) * unit <= LARGEST_THING)
        return ups[0], unit or (1.0 if in_metres else next(fitting, 1.0))
    extents = np.maximum(extents, 1e-9)
    if unit is not None:
        guess = _likelier(sizes, extents, ups, [unit])
        if _misfit(sizes, extents, guess) < FAR:
            return guess
    best = min(product(ups, UNITS), key=lambda guess: _misfit(sizes, extents, guess))
    if _misfit(sizes, extents, best) > HOPELESS and not in_metres:
        factors = [sizes.factor(*_plan_and_height(extents, up)) for up in ups]
        guesses = zip(ups, factors, strict=True)
        as_usual = min(guesses, key=lambda guess: _misfit(sizes, extents, guess))
        if _misfit(sizes, extents, as_usual) < UNLIKELY:
            return as_usual
    return _likelier(sizes, extents, ups, list(UNITS))


def _likelier(sizes: Usual, extents: Matrix, ups: Sequence[Axis], units: Sequence[float]) -> tuple[Axis, float]:
    """The first up and unit, or others that fit far better."""
    first = (ups[0], units[0])
    best = min(((up, unit) for unit, up in product(units, ups)), key=lambda guess: _misfit(sizes, extents, guess))
    least = max(UNLIKELY, BETTER * _misfit(sizes, extents, best))
    return best if _misfit(sizes, extents, first) > least else first


def unit_told(extents: Matrix, category: str, ups: Sequence[Axis]) -> float | None:
    """Metres per unit in which a model's extents (3,) are usual in its category; None: in none, or it is not ours."""
    sizes = usual(category)
    if sizes is None:
        return None
    extents = np.maximum(extents, 1e-9)
    guess = up_and_unit(extents, category, ups, in_metres=True)
    return guess[1] if _misfit(sizes, extents, guess) < UNLIKELY else None


def _misfit(sizes: Usual, extents: Matrix, guess: tuple[Axis, float]) -> float:
    plan, height = _plan_and_height(extents, guess[0])
    return round(sizes.misfit(plan * guess[1], height * guess[1]), 6)


def _plan_and_height(extents: Matrix, up: Axis) -> tuple[Matrix, float]:
    axis = "xyz".index(up[1])
    return np.delete(extents, axis), float(extents[axis])


def up_as_it_stands(points: Matrix, category: str, default: Axis, agreed: bool) -> Axis:
    """The direction up in which a rigid model (N, 3) stands on its foot; the default if it does, or in none.

    Where the kind of file has no `agreed` direction, the default counts for no more than the other.
    """
    if category in HUNG:
        return default
    if not agreed:
        return leaning(points) or default
    other = other_up(default)
    return other if _stands(points, other) and not _stands(points, default) else default


def other_up(up: Axis) -> Axis:
    """The other direction that files call up."""
    return "+z" if up == "+y" else "+y"


def leaning(points: Matrix) -> Axis | None:
    """Which of +y and +z is up in a rigid model (N, 3): in which it stands on its foot, and its foot is at the origin's
    height; None: that tells neither."""
    y, z = (_stands(points, up) + _at_zero(points, up) for up in UPS)
    return None if y == z else "+y" if y > z else "+z"


def _stands(points: Matrix, up: Axis) -> bool:
    """Whether it touches the ground along both directions of its ground plan: what lies on a round side does not."""
    axis = "xyz".index(up[1])
    height, plan = points[:, axis], np.delete(points, axis, axis=1)
    foot = plan[height <= height.min() + BOTTOM * np.ptp(height)]
    return bool((np.ptp(foot, axis=0) >= FOOT * np.ptp(plan, axis=0)).all())


def _at_zero(points: Matrix, up: Axis) -> bool:
    """Whether its lowest point is at the origin's height."""
    heights = points[:, "xyz".index(up[1])]
    return bool(abs(heights.min()) < ORIGIN * np.ptp(heights))


def scale_from_sphere(extents: Matrix, category: str) -> float | None:
    """Metres per unit of a model (3,), z up, that was scaled into a sphere of radius 1, as PartNet's are.

    None: it fits into no such sphere, or ours has no such category.
    """
    sizes = usual(category)
    if sizes is None or abs(float(np.linalg.norm(extents)) / 2 - 1) > SPHERE:
        return None
    return sizes.factor(extents[:2], extents[2])


def doubt_of_size(size: tuple[float, float, float], category: str) -> str | None:
    """A line if no model of the category has the size of this one (metres, z up), or it seems to lie on its side."""
    sizes = usual(category)
    if sizes is None:
        return None if max(size) <= LARGEST_THING else f"is {max(size):.3g} m large: a room, or not in metres?"
    extents = np.maximum(size, 1e-9)
    misfit, *lying = (sizes.misfit(np.delete(extents, up), extents[up]) for up in (2, 0, 1))
    if misfit > LYING and BETTER * min(lying) < misfit:
        return f"seems to lie on its side: a {category.replace('_', ' ')} of ours is {sizes} (asset.json: up)"
    if misfit <= UNLIKELY:
        return None
    factor = sizes.factor(extents[:2], extents[2])
    line = f"no {category.replace('_', ' ')} of ours has such a size: {sizes}"
    if sizes.misfit(extents[:2] * factor, extents[2] * factor) < UNLIKELY:
        line += f"; {factor:g} times its scale would be usual"
    return line
