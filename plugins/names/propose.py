"""Propose names for the thing that a mask shows: what looks, size and height say, each with a weight of its own."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plugins.names.observed import Observed

Array = NDArray[np.float64]
TABLE = Path(__file__).with_name("names.npz")
FEET = (-0.05, 0.05, 0.3, 0.6, 0.9, 1.3)  # metres: between them heights of feet are alike; chosen


class Proposal(NamedTuple):
    """A category of the library, in words, and how sure it is, 0 to 1."""

    name: str
    probability: float


@dataclass(frozen=True)
class Table:
    """What is known of C categories.

    Attributes:
        names: (C,).
        looks: (C, 112) by which a mean feature is multiplied, and `offset` (C,) added to it: log-likelihoods by
            Gaussians of one covariance (LDA).
        size: (C, 3) means of logarithms of what is seen of extents, and `spread` (C, 3) their standard deviations.
        feet: (C, 7) log-probabilities of heights between `FEET`.
        weights: (3,) of looks, size and feet.
    """

    names: NDArray[np.str_]
    looks: Array
    offset: Array
    size: Array
    spread: Array
    feet: Array
    weights: Array


@cache
def read_table() -> Table:
    """The table that is shipped."""
    with np.load(TABLE) as file:
        numbers = {name: file[name].astype(float) for name in file.files if name != "names"}
        return Table(names=file["names"], **numbers)


def say(observed: Observed, table: Table) -> Array:
    """Log-likelihoods (3, C) of what is observed, by looks, size and foot; 0: nothing is known."""
    said = np.zeros((3, len(table.names)))
    said[0] = table.looks @ observed.looks + table.offset
    if observed.size is not None:
        off = (observed.size - table.size) / table.spread
        said[1] = -(off**2 / 2 + np.log(table.spread)).sum(axis=1)
    if observed.foot is not None:
        said[2] = table.feet[:, np.searchsorted(FEET, observed.foot)]
    return said


def propose_names(observed: Observed, table: Table | None = None, among: Sequence[str] | None = None) -> list[Proposal]:
    """The categories, surest first; every one is as likely before anything is observed.

    Args:
        observed: of a mask, see `observe`.
        table: of what is known; None: the one that is shipped.
        among: names that come into question; None: all.
    """
    table = table or read_table()
    total = table.weights @ say(observed, table)
    if among is not None:
        total = np.where(np.isin(table.names, list(among)), total, -np.inf)
    share = np.exp(total - total.max())
    share /= share.sum()
    order = np.argsort(-share, kind="stable")
    words = [str(name).replace("_", " ") for name in table.names]
    return [Proposal(words[one], float(share[one])) for one in order if np.isfinite(total[one])]
