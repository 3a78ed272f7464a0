"""Verb `learn`: write the table of what is known of the categories, from random rooms of our own models."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plugins.names.examples import Example, draw_examples
from plugins.names.propose import FEET, OUT, TABLE, Array, Table, place_at_wall
from stages.contracts.files import write_atomically

SHRINK = 0.1  # of the covariance of looks towards its mean variance; chosen
LEAST_SPREAD = 0.15  # of logarithms of extents; chosen: rooms of others have other sizes


def learn_table(examples: list[Example]) -> Table:
    """What examples say of their categories."""
    names = np.unique([one.name for one in examples])
    which = np.searchsorted(names, [one.name for one in examples])
    looks = np.array([one.observed.looks for one in examples])
    means = np.array([looks[which == one].mean(axis=0) for one in range(len(names))])
    apart = looks - means[which]
    covariance = apart.T @ apart / len(looks)
    shrunk = (1 - SHRINK) * covariance + SHRINK * np.trace(covariance) / len(covariance) * np.eye(len(covariance))
    axes = np.linalg.solve(shrunk, means.T).T
    sizes = [
        np.array([e.observed.size for e in examples if e.name == name and e.observed.size is not None])
        for name in names
    ]
    spread = np.array([np.cov(size.T, bias=True) for size in sizes]) + LEAST_SPREAD**2 * np.eye(3)
    deep = [one for one in examples if one.observed.foot is not None]
    rows = np.searchsorted(names, [one.name for one in deep])
    feet = np.searchsorted(FEET, [one.observed.foot for one in deep])  # type: ignore[arg-type]
    out = np.array([place_at_wall(one.observed.out) for one in deep])
    return Table(
        names=names,
        looks=axes,
        offset=-(axes * means).sum(axis=1) / 2,
        size=np.array([size.mean(axis=0) for size in sizes]),
        whiten=np.linalg.inv(np.linalg.cholesky(spread)),
        feet=log_shares(rows, feet, (len(names), len(FEET) + 1)),
        out=log_shares(rows, out, (len(names), len(OUT) + 3)),
    )


def log_shares(rows: NDArray[np.int64], columns: NDArray[np.int64], shape: tuple[int, int]) -> Array:
    """Log-probabilities of the columns in each row, one added to every count (Laplace)."""
    counts = np.ones(shape)
    np.add.at(counts, (rows, columns), 1)
    return np.log(counts / counts.sum(axis=1, keepdims=True))


def write_table(out: Path, table: Table) -> None:
    """Write the table, numbers as float32."""
    numbers = {name: values.astype(np.float32) for name, values in vars(table).items() if name != "names"}
    with write_atomically(out) as path, path.open("wb") as file:
        np.savez(file, allow_pickle=False, names=table.names, **numbers)


def run(*, out: Path = TABLE, each: int = 40, models: int = 8, rooms: int = 130, seed: int = 1) -> None:
    """Write the table.

    Args:
        out: the file.
        each: things of a category at most.
        models: of a category.
        rooms: at most.
        seed: of models and rooms.
    """
    examples = draw_examples(each, models, seed, rooms)
    table = learn_table(examples)
    write_table(out, table)
    print(f"{out}: {len(table.names)} categories, {len(examples)} things")
