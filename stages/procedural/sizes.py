"""How large the things of a category usually are, by the sizes that its models are sampled from."""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stages.procedural.catalogue import CATEGORIES, sample

Array = NDArray[np.float64]
SAMPLES = 8  # models of a category that say how large it is
SPREAD = np.log(1.5)  # by which an extent may lie beyond those of the samples and still be usual


class Usual(NamedTuple):
    """Logarithms of the least and the largest extents of a category: ground plan's shorter, its longer, height."""

    low: Array
    high: Array

    def misfit(self, size: Array, spread: float = SPREAD) -> float:
        """Sum of the logarithms of how far extents (3,), metres, z up, lie beyond the usual; 0: they are usual."""
        extents = np.log([*np.sort(size[:2]), size[2]])
        return float(np.maximum(0, np.maximum(self.low - spread - extents, extents - self.high - spread)).sum())

    def factor(self, size: Array) -> float:
        """What would make it as large as usual, two digits."""
        extents = np.log([*np.sort(size[:2]), size[2]])
        return float(f"{np.exp(np.mean((self.low + self.high) / 2 - extents)):.2g}")

    def __str__(self) -> str:
        low, high = np.exp(self.low) * 100, np.exp(self.high) * 100
        (a, b, c), (d, e, f) = low.round().astype(int), high.round().astype(int)
        return f"{a} to {d} by {b} to {e} cm, {c} to {f} cm high"


@cache
def sizes_of(category: str, further: bool = False) -> Array:
    """Depth, width and height (N, 3) of the first models of a category of ours, metres; (0, 3): there is no such.

    `further`: and of those in further styles.
    """
    record = CATEGORIES.get(category)
    numbers = [*range(SAMPLES), *(record.further if further else ())] if record else []
    sizes = [sample(category, k, 0).parameters["size"] for k in numbers]
    return np.array(sizes, dtype=float).reshape(-1, 3)


def usual(category: str | None, further: bool = False) -> Usual | None:
    """The sizes of a category of ours, with its further styles or without; None: there is no such category."""
    sizes = sizes_of(category or "", further)
    if not len(sizes):
        return None
    extents = np.log(np.c_[np.sort(sizes[:, :2], axis=1), sizes[:, 2]])
    return Usual(extents.min(axis=0), extents.max(axis=0))


def unusual(category: str | None, size: Array, spread: float = SPREAD) -> str:
    """What is odd about extents (depth, width, height), metres, of a thing of a category of ours; empty: nothing.

    Which of depth and width is which does not matter. `spread`: as `SPREAD`.
    """
    known = usual(category, further=True)
    if known is None or known.misfit(size, spread) == 0:
        return ""
    shorter, longer = np.sort(size[:2])
    return f"is {100 * shorter:.0f} by {100 * longer:.0f} cm, {100 * size[2]:.0f} cm high; usual are {known}"
