"""Verb `learn`: write the table of what is known of the categories, from random rooms of our own models."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from plugins.names.examples import Example, draw_examples
from plugins.names.propose import FEET, TABLE, Array, Table, say
from stages.contracts.files import write_atomically

SHRINK = 0.1  # of the covariance of looks towards its mean variance; chosen
DISTRUST = 0.5  # of the weight of looks: rooms that are rendered are easier; chosen on 24 things of 5 real pictures
LEAST_SPREAD = 0.15  # of logarithms of extents; chosen: rooms of others have other sizes


def learn_table(examples: list[Example], weights: Array) -> Table:
    """What examples say of their categories."""
    names = np.unique([one.name for one in examples])
    which = np.searchsorted(names, [one.name for one in examples])
    looks = np.array([one.observed.looks for one in examples])
    means = np.array([looks[which == one].mean(axis=0) for one in range(len(names))])
    apart = looks - means[which]
    covariance = apart.T @ apart / len(looks)
    shrunk = (1 - SHRINK) * covariance + SHRINK * np.trace(covariance) / len(covariance) * np.eye(len(covariance))
    axes = np.linalg.solve(shrunk, means.T).T
    unknown = np.full(3, np.nan)
    size = np.array([unknown if one.observed.size is None else one.observed.size for one in examples])
    feet = np.ones((len(names), len(FEET) + 1))
    for at, one in zip(which, examples, strict=True):
        if one.observed.foot is not None:
            feet[at, np.searchsorted(FEET, one.observed.foot)] += 1
    return Table(
        names=names,
        looks=axes,
        offset=-(axes * means).sum(axis=1) / 2,
        size=np.array([np.nanmean(size[which == one], axis=0) for one in range(len(names))]),
        spread=np.array([np.hypot(np.nanstd(size[which == one], axis=0), LEAST_SPREAD) for one in range(len(names))]),
        feet=np.log(feet / feet.sum(axis=1, keepdims=True)),
        weights=weights,
    )


def choose_weights(table: Table, examples: list[Example]) -> Array:
    """The weights (3,) by which examples that the table does not know are most likely: calibrated with it."""
    said = np.array([say(one.observed, table) for one in examples])
    true = np.searchsorted(table.names, [one.name for one in examples])
    share = 1 / np.bincount(true, minlength=len(table.names))[true]  # every category counts as much

    def loss(weights: Array) -> float:
        total = np.einsum("k,nkc->nc", weights, said)
        top = total.max(axis=1)
        log_sum = top + np.log(np.exp(total - top[:, None]).sum(axis=1))
        return float((share * (log_sum - total[np.arange(len(true)), true])).sum() / share.sum())

    return np.asarray(minimize(loss, np.full(3, 0.5), method="Nelder-Mead", bounds=[(0, 2)] * 3).x)


def write_table(out: Path, table: Table) -> None:
    """Write the table, numbers as float32."""
    numbers = {name: values.astype(np.float32) for name, values in vars(table).items() if name != "names"}
    with write_atomically(out) as path, path.open("wb") as file:
        np.savez(file, allow_pickle=False, names=table.names, **numbers)


def run(*, out: Path = TABLE, each: int = 80, models: int = 16, rooms: int = 260, seed: int = 0) -> None:
    """Write the table.

    Args:
        out: the file.
        each: things of a category at most; half as many of other models choose the weights.
        models: of a category.
        rooms: at most.
        seed: of models and rooms.
    """
    table = learn_table(draw_examples(each, models, seed, rooms), np.ones(3))
    others = draw_examples(each // 2, models // 2, seed + 1, rooms // 2)
    weights = choose_weights(table, others) * [DISTRUST, 1, 1]
    write_table(out, replace(table, weights=weights))
    print(f"{out}: {len(table.names)} categories; weights of looks, size and feet {weights.round(2)}")
