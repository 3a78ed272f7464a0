"""Propose names for the thing that a mask shows: what looks, size and place say, as if each were independent."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from plugins.names.observed import Observed

Array = NDArray[np.float64]
TABLE = Path(__file__).with_name("names.npz")
CLASSES = Path(__file__).with_name("classes.yaml")
WEIGHTS = (
    0.15,
    1,
    1,
    1,
    1,
)  # of looks, classes, size, foot, out: our own pictures teach looks badly; benchmarks/names.py
FEET = (-0.05, 0.05, 0.3, 0.6, 0.9, 1.3)  # metres: between them heights of feet are alike; chosen
OUT = (0.1, 0.25, 0.6)  # metres out of a wall, between which things are alike; chosen
BEHIND = -0.75  # metres out of a wall: what is seen there is in a mirror; chosen
OTHER = 0.02  # added to the share of a category's classes: of 64 about one; chosen


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
        size: (C, 3) means of logarithms of what is seen of extents; `whiten` (C, 3, 3) makes what differs from them
            white.
        feet: (C, 7) log-probabilities of heights between `FEET`.
        out: (C, 6) log-probabilities of `place_at_wall`.
    """

    names: NDArray[np.str_]
    looks: Array
    offset: Array
    size: Array
    whiten: Array
    feet: Array
    out: Array


@cache
def read_table() -> Table:
    """The table that is shipped."""
    with np.load(TABLE) as file:
        numbers = {name: file[name].astype(float) for name in file.files if name != "names"}
        return Table(names=file["names"], **numbers)


@cache
def read_classes() -> dict[str, list[int]]:
    """The classes of ImageNet that are a category."""
    return {name: list(classes) for name, classes in yaml.safe_load(CLASSES.read_text(encoding="utf-8")).items()}


def share_classes(scores: Array, names: Sequence[str]) -> Array:
    """The share (C,) of each category among those classes of ImageNet (1000 scores) that are ours at all."""
    classes = read_classes()
    ours = sorted({one for name in names for one in classes.get(name, [])})
    share = np.zeros(len(scores))
    share[ours] = np.exp(scores[ours] - scores[ours].max())
    share /= share.sum()
    return np.array([share[classes.get(name, [])].sum() for name in names])


def place_at_wall(out: Array | None) -> int:
    """0: there is no wall around it; 1: it is a mirror; else by how far it stands out of it."""
    if out is None:
        return 0
    return 1 if out[0] < BEHIND else 2 + int(np.searchsorted(OUT, out[1]))


def say(observed: Observed, table: Table) -> Array:
    """Log-likelihoods (5, C) of what is observed, in the order of `WEIGHTS`; 0: nothing is known."""
    said = np.zeros((len(WEIGHTS), len(table.names)))
    said[0] = table.looks @ observed.looks + table.offset
    if observed.classes is not None:
        said[1] = np.log(share_classes(observed.classes, [str(name) for name in table.names]) + OTHER)
    if observed.size is not None:
        off = np.einsum("cij,cj->ci", table.whiten, observed.size - table.size)
        said[2] = np.linalg.slogdet(table.whiten).logabsdet - (off**2).sum(axis=1) / 2
    if observed.foot is not None:
        said[3] = table.feet[:, np.searchsorted(FEET, observed.foot)]
        said[4] = table.out[:, place_at_wall(observed.out)]
    return said


def propose_names(observed: Observed, table: Table | None = None, among: Sequence[str] | None = None) -> list[Proposal]:
    """The categories, surest first; every one is as likely before anything is observed.

    Args:
        observed: of a mask, see `observe`.
        table: of what is known; None: the one that is shipped.
        among: names that come into question; None: all.
    """
    table = table or read_table()
    total = np.array(WEIGHTS) @ say(observed, table)
    if among is not None:
        total = np.where(np.isin(table.names, list(among)), total, -np.inf)
    share = np.exp(total - total.max())
    share /= share.sum()
    order = np.argsort(-share, kind="stable")
    words = [str(name).replace("_", " ") for name in table.names]
    return [Proposal(words[one], float(share[one])) for one in order if np.isfinite(total[one])]
