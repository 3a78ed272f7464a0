"""A category of models: what people call it, what it opens, how large its things usually are."""

import re
from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from roomkin.stages.contracts.errors import describe_size
from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.types import Id, Panels, Size, Text

Array = NDArray[np.float64]
Place = Literal["floor", "top", "wall"]
# Where things carry others: on the level top that they end in, on a seat before a back, on the upper of their boards,
# inside, as a floor does; empty: nowhere.
Carries = Literal["", "top", "seat", "boards", "inside", "floor"]
FEWEST_MODELS = 3  # that say how large a category is: the next one is outside n others with 2 chances of n + 1
UNLIKE = 0.15  # deviation of logarithms of extents; chosen on `work`
USUAL_SPREAD = float(np.log(1.5))  # by which an extent may lie beyond those of its category's models and still be usual
# Words after that of a category that make another thing of it, or a part: `table_leg`, `bowl_drainer`.
PARTS = {
    "caddy", "door", "drainer", "handle", "holder", "knob", "leg", "lid", "panel", "rack", "seat", "shelf", "stand",
    "window",
}  # fmt: skip


class UsualSize(NamedTuple):
    """Logarithms of the least and the largest extents of a category: ground plan's shorter, its longer, height."""

    low: Array
    high: Array

    def misfit(self, size: ArrayLike, spread: float = USUAL_SPREAD) -> float:
        """Sum of the logarithms of how far extents (3,), metres, z up, lie beyond the usual; 0: they are usual."""
        extents = log_extents(size)
        return float(np.maximum(0, np.maximum(self.low - spread - extents, extents - self.high - spread)).sum())

    def factor(self, size: ArrayLike) -> float:
        """The factor that would make it as large as usual, two digits."""
        return float(f"{np.exp(np.mean((self.low + self.high) / 2 - log_extents(size))):.2g}")

    def describe(self, deeper: bool) -> str:
        """In words: '60 to 80 wide × 4 deep × 90 to 120 cm high'; `deeper`: of a thing that is deeper than wide."""
        ends = np.exp([self.low, self.high]).T * 100
        short, long, high = (" to ".join(dict.fromkeys(f"{end:.0f}" for end in each)) for each in ends)
        wide, deep = (short, long) if deeper else (long, short)
        return f"{wide} wide × {deep} deep × {high} cm high"


class SizeSpread(NamedTuple):
    """Mean (3,) and covariance (3, 3) of the logarithms of depth, width and height, metres."""

    mean: Array
    covariance: Array

    def turn(self) -> "SizeSpread":
        """The same of width, depth and height."""
        order = [1, 0, 2]
        return SizeSpread(self.mean[order], self.covariance[np.ix_(order, order)])


def log_extents(size: ArrayLike) -> Array:
    """Logarithms of extents (..., 3), z up: which of depth and width is which does not matter."""
    size = np.asarray(size, dtype=float)
    return np.log(np.concatenate([np.sort(size[..., :2], axis=-1), size[..., 2:]], axis=-1))


class CategoryFacts(Contract):
    """A category, as the maker of the library knows it. Sizes: depth, width and height of models of it, metres."""

    name: Id = Field(description="lower-case words joined by underscores")
    names: list[Text] = Field([], description="what else it is called: labels and file names that say so mean it")
    like: list[Text] = Field([], description="words for similar things: a label that says so is nearest to it")
    kin: list[Text] = Field([], description="kinds of things that it is one of: labels of no category are nearest")
    places: list[Place] = Field(["floor"], description="where its things are; top: on what carries things")
    carries: Carries = Field("", description="where its things carry others; empty: nowhere")
    doors: Panels = Field(0, description="on upright hinges, of all of its first models together")
    flaps: Panels = Field(0, description="on level hinges, likewise")
    sizes: list[Size] = Field([], description="of models that say how large it usually is")
    further: list[Size] = Field([], description="of models in styles that those lack")
    real: list[Size] = Field([], description="of real things, by standards and catalogues, between which others lie")

    def measure_usual_size(self, further: bool = False) -> UsualSize | None:
        """Its sizes, with those in further styles and of real things or without; None: too few models say so."""
        sizes = [*self.sizes, *((*self.further, *self.real) if further else ())]
        if len(sizes) < FEWEST_MODELS:
            return None
        extents = log_extents(sizes)
        return UsualSize(extents.min(axis=0), extents.max(axis=0))

    def find_usual_depth(self) -> float | None:
        """How deep its things are; None: no model says so."""
        return float(np.median([depth for depth, _, _ in self.sizes])) if self.sizes else None

    def measure_spread(self) -> SizeSpread | None:
        """How large its things usually are; None: too few models say so.

        Things of the world differ by `UNLIKE` more than the models and catalogues do.
        """
        sizes = np.log([*self.sizes, *self.further, *self.real] or np.empty((0, 3)))
        if len(sizes) < FEWEST_MODELS:
            return None
        return SizeSpread(sizes.mean(axis=0), np.cov(sizes.T) + UNLIKE**2 * np.eye(3))


def describe_unusual(category: CategoryFacts | None, size: ArrayLike, spread: float = USUAL_SPREAD) -> str:
    """Oddities of extents (depth, width, height), metres, of a thing of a category; empty: nothing is known.

    `spread`: as `USUAL_SPREAD`.
    """
    usual = category.measure_usual_size(further=True) if category else None
    if usual is None or usual.misfit(size, spread) == 0:
        return ""
    depth, width, _ = size = np.asarray(size, dtype=float)
    return f"is {describe_size(size)}; usual are {usual.describe(deeper=depth > width)}"


def split_words(name: str) -> list[str]:
    """The words of a name, lower case, without numbers: `studyTable_2` has two."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)]


def list_singulars(word: str) -> list[str]:
    """A word, and what it may be the plural of: `mugs`, `boxes`, `shelves`."""
    return [word, word.removesuffix("s"), word.removesuffix("es"), re.sub("ves$", "f", word)]


def may_stand_on(upper: CategoryFacts | None, lower: CategoryFacts | None) -> bool:
    """Whether things of a category may stand on those of another; None, which is not known, may be anything."""
    if upper is not None and upper.places == ["floor"]:
        return lower is not None and lower.carries == "floor"
    return lower is None or lower.carries != ""


def by_joined_name(known: Mapping[str, CategoryFacts], like: bool = False) -> dict[str, CategoryFacts]:
    """Categories by all their names, without spaces: `coffeetable`; `like`: and by words for similar things."""
    similar = {re.sub("[ _]", "", word): one for one in known.values() for word in one.like if like}
    return similar | {re.sub("[ _]", "", word): one for one in known.values() for word in (one.name, *one.names)}


def find_category(name: str, known: Mapping[str, CategoryFacts], like: bool = False) -> CategoryFacts | None:
    """The category that a name means (a label of a person, a file), by its last words: `025_mug`, `studyTable`.

    Args:
        known: categories by name.
        like: or to which the things that it means are similar.
    """
    by_word, words = by_joined_name(known, like), split_words(name)
    for end in range(len(words), 0, -1):
        if end < len(words) and words[-1] in PARTS and "with" not in words:
            return None
        for start in range(end):
            joined = "".join(words[start:end])
            if found := next((by_word[each] for each in list_singulars(joined) if each in by_word), None):
                return found
    return None
