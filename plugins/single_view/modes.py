"""What a thing may be in the fit (turned, across the room, outlined without its legs), and the fit over all of it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from plugins.single_view.fit import HEIGHT, Array, CameraPrior, Item, Layout, list_carriers

MISSED_LEGS = 2.0  # cost of an outline that lacks a thing's legs; chosen on `work`
ACROSS = 1.0  # cost of a thing that stands across the room; chosen on `work`
FIRST_STEPS = -3.0, -2.0, -1.0, 0.0, 1.0, 2.0  # deviations of the camera's height that are tried first
KEPT, ROUNDS = 2, 2  # of these, how many are improved, and how often; chosen
BOTTOM = np.array([False, False, False, True])


class Fitted(NamedTuple):
    """The things as they fit best, the state, and its cost."""

    layout: Layout
    state: Array
    cost: float


def list_modes(item: Item) -> list[Item]:
    """What a thing may be."""
    modes = [item]
    if item.legs and item.on < 0 and not item.open[3]:
        modes.append(replace(item, open=item.open | BOTTOM, endless=True, penalty=MISSED_LEGS))
    if item.across:
        modes += [replace(one, yaw=np.pi / 4, penalty=one.penalty + ACROSS) for one in modes]
    return [replace(one, yaw=one.yaw + turn) for one in modes for turn in (0.0, np.pi / 2)]


def choose_modes(camera: CameraPrior, items: Sequence[Item], state: Array) -> tuple[list[Item], Array]:
    """The best mode of each thing with this camera (5,), and what each costs (N,); carriers before what they carry."""
    chosen, costs = list(items), np.zeros(len(items))
    levels = [len(list_carriers(items, k)) for k in range(len(items))]
    for level in range(max(levels) + 1):
        now = [k for k in range(len(items)) if levels[k] == level]
        below = sorted({one for k in now for one in list_carriers(items, k)})
        place = {-1: -1} | {k: number for number, k in enumerate(below)}
        modes = [(k, mode) for k in now for mode in list_modes(items[k])]
        tried = [*(chosen[k] for k in below), *(mode for _, mode in modes)]
        each = Layout(camera, [replace(one, on=place[one.on]) for one in tried]).place(state)[1][len(below) :]
        for k in now:
            own = [number for number, (of, _) in enumerate(modes) if of == k]
            best = min(own, key=lambda number: float(each[number]))
            chosen[k], costs[k] = modes[best][1], each[best]
    return chosen, costs


def fit_things(camera: CameraPrior, items: Sequence[Item]) -> Fitted:
    """The best fit: the camera's height by trial, each thing in its best mode, then all together, and once more."""
    states = [np.array([*camera.state, HEIGHT[0] + HEIGHT[1] * step]) for step in FIRST_STEPS]
    totals = [
        choose_modes(camera, items, state)[1].sum() + step**2 / 2
        for state, step in zip(states, FIRST_STEPS, strict=True)
    ]
    fits = list[Fitted]()
    for first in np.argsort(totals, kind="stable")[:KEPT]:
        state = states[first]
        for _ in range(ROUNDS):
            layout = Layout(camera, choose_modes(camera, items, state)[0])
            fits.append(Fitted(layout, *layout.improve(layout.place(state)[0])))
            state = fits[-1].state[:5]
    return min(fits, key=lambda fit: fit.cost)
