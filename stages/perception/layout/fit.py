"""One robust fit of the camera and of every box of a picture without depth: lines, outlines and usual sizes together.

Least squares over the camera's direction, focal length and height, and each thing's place and extents, in deviations.
Lines, outlines and sizes count as Cauchy's: turned furniture, a part that an outline lacks, odd sizes are no Gaussian.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import csr_array

from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import rotation_of
from roomkin.stages.geometry.robust import UNUSUAL
from roomkin.stages.perception.camera import perspective
from roomkin.stages.perception.camera.metrology import PinholeView
from roomkin.stages.perception.camera.perspective import Perspective, angles_of, measure_misses, weigh_residuals
from roomkin.stages.perception.classification.names import ODD
from roomkin.stages.perception.layout.ends import FitItem

Array = NDArray[np.float64]
HEIGHT = float(np.log(1.4)), 0.2  # mean and deviation of the logarithm of a camera's height above the floor, metres
END = 3.0, 0.04  # pixels, and share of the extent, by which an outline's end is not that of its box; chosen on `work`
OVER = 0.3  # of the lesser side of a thing that may reach beyond what carries it; chosen
SLACK = 0.05  # metres by which its place may be wrong there; chosen
NEAR = 0.1  # metres before the camera: corners that are nearer or behind it are taken to be there
NEAREST, FARTHEST = 0.4, 12.0  # metres at which things are first looked for
STEPS_ALONE, STEPS = 25, 40  # of the least squares with a camera that stays, and of all; more change nothing
SIGNS = np.array([(x, y, z) for z in (0, 1) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])  # corners, from the foot
CAMERA, BOX = 5, 5  # numbers of a state: of the camera, of each thing
LINES_BESIDE = 5  # terms of the camera beside its lines
MISSED_LEGS = 2.0  # cost of an outline that lacks a thing's legs; chosen on `work`
ACROSS = 1.0  # cost of a thing that stands across the room; chosen on `work`
FIRST_STEPS = -3.0, -2.0, -1.0, 0.0, 1.0, 2.0  # deviations of the camera's height that are tried first
KEPT, ROUNDS = 2, 2  # of these, how many are improved, and how often; chosen
BOTTOM = np.array([False, False, False, True])


@dataclass(frozen=True)
class CameraPrior:
    """What is known of the camera: lines and focal length, and the view that fits these, one metre high."""

    given: Perspective
    view: PinholeView

    @property
    def state(self) -> Array:
        """Yaw, pitch, roll and the logarithm of the focal length."""
        return np.array([*angles_of(self.view.rotation), np.log(self.view.focal)])

    def view_of(self, state: Array) -> PinholeView:
        """The camera of a state."""
        size = self.view.width, self.view.height
        return PinholeView(*size, float(np.exp(state[3])), rotation_of(*state[:3]), float(np.exp(state[4])))


class Layout:
    """The fit of some things. A state is (5 + 5 N,): the camera's yaw, pitch, roll and the logarithms of its focal
    length and height; each thing's bearing, and the logarithms of its distance on the floor and of its extents."""

    def __init__(self, camera: CameraPrior, items: Sequence[FitItem]) -> None:
        self.camera, self.items = camera, items
        self.at = np.array([item.ends.at for item in items])
        self.open = np.array([item.open for item in items])
        self.limit = np.where([item.ends.cut for item in items], np.inf, [item.ends.limit for item in items])
        self.limit[[item.endless for item in items], 3] = np.inf
        self.mean = np.array([item.usual.mean for item in items])
        self.root = np.array([np.linalg.cholesky(np.linalg.inv(item.usual.covariance)).T for item in items])
        self.on = [item.on for item in items]
        self.yaw = np.array([item.yaw for item in items])
        self.ground = np.array([item.ground for item in items])
        extent = np.stack([self.at[:, 0] + self.at[:, 2], self.at[:, 1] + self.at[:, 3]] * 2, axis=1)
        self.noise = np.hypot(END[0], END[1] * extent)
        self.order = sorted(range(len(items)), key=lambda k: len(list_carriers(items, k)))
        self.sparsity = self._list_dependences()

    def place_things(self, state: Array) -> tuple[Array, Array]:
        """Feet (N, 3) of the things, the middle of what they stand with, and their extents (N, 3), in the room."""
        bearing, reach, sizes = np.split(state[CAMERA:].reshape(-1, BOX), [1, 2], axis=1)
        sizes, feet = np.exp(sizes), np.zeros((len(self.items), 3))
        feet[:, 2] = self.ground
        feet[:, :2] = np.exp(reach) * np.concatenate([np.sin(bearing), np.cos(bearing)], axis=1)
        for k in self.order:
            if self.on[k] >= 0:
                feet[k, 2] = feet[self.on[k], 2] + sizes[self.on[k], 2]
        return feet, sizes

    def list_boxes(self, state: Array) -> list[UprightBox]:
        """The boxes of the things, in the room."""
        feet, sizes = self.place_things(state)
        centers = feet + sizes * [0, 0, 0.5]
        return [UprightBox(*one) for one in zip(centers, sizes, self.yaw.tolist(), strict=True)]

    def project(self, state: Array) -> Array:
        """Pixels (N, 8, 2) of the corners."""
        view, (feet, sizes) = self.camera.view_of(state), self.place_things(state)
        x, y, z = np.moveaxis(SIGNS * sizes[:, None], -1, 0)
        c, s = np.cos(self.yaw)[:, None], np.sin(self.yaw)[:, None]
        corners = np.stack([c * x - s * y, s * x + c * y, z], axis=-1) + feet[:, None]
        seen = (corners - [0, 0, view.above]) @ view.rotation
        flat = seen[..., :2] / np.maximum(seen[..., 2:], NEAR)
        return np.asarray(flat * view.focal + view.center)

    def measure_things(self, state: Array) -> tuple[Array, Array, Array]:
        """Deviations of the ends (N, 4), of the sizes (N, 3), and of the places on what carries them (N, 2)."""
        pixels, (feet, sizes) = self.project(state), self.place_things(state)
        beyond = np.concatenate([-pixels.min(axis=1), pixels.max(axis=1)], axis=1) - self.at
        allowed = np.minimum(beyond, 0) + np.maximum(beyond + self.at - self.limit, 0)
        ends = np.where(self.open, allowed, beyond) / self.noise
        odd = np.einsum("nij,nj->ni", self.root, np.log(sizes) - self.mean)
        off = np.zeros((len(self.items), 2))
        for k, on in enumerate(self.on):
            if on >= 0:
                c, s = np.cos(self.yaw[on]), np.sin(self.yaw[on])
                local = np.abs(np.array([[c, s], [-s, c]]) @ (feet[k] - feet[on])[:2])
                off[k] = np.maximum(local - sizes[on, :2] / 2 + OVER * min(sizes[k, :2]), 0) / SLACK
        return ends, odd, off

    def measure_deviations(self, state: Array) -> Array:
        """All deviations of a state, those that are Cauchy's so that half their squares add up to the cost."""
        ends, odd, off = self.measure_things(state)
        robust = UNUSUAL * weigh_residuals(np.concatenate([ends.ravel(), odd.ravel()]) / UNUSUAL)
        return np.concatenate([measure_camera(self.camera, state), robust, off.ravel()])

    def measure_costs(self, state: Array) -> Array:
        """Cost (N,) of each thing: minus the logarithm of how likely its ends, its size and its place are."""
        ends, odd, off = self.measure_things(state)
        robust = UNUSUAL**2 * np.log1p(np.concatenate([ends, odd], axis=1) ** 2 / UNUSUAL**2)
        return np.asarray((robust.sum(axis=1) + (off**2).sum(axis=1)) / 2 + [item.penalty for item in self.items])

    def start(self, camera: Array) -> Array:
        """A state with this camera (5,): each thing where its foot meets the floor, else as far as its size says."""
        state = np.concatenate([camera, np.zeros(BOX * len(self.items))])
        view, rows = self.camera.view_of(state), state[CAMERA:].reshape(-1, BOX)
        rows[:, 2:], sizes = self.mean, np.exp(self.mean)
        for k in self.order:
            left, top, right, bottom = self.at[k] * [-1, -1, 1, 1]
            foot, middle = view.rays([[(left + right) / 2, bottom], [(left + right) / 2, (top + bottom) / 2]])
            rows[k, 0] = np.arctan2(middle[0], middle[1])
            if self.on[k] >= 0:
                rows[k, 1] = rows[self.on[k], 1]
                continue
            by_width, by_height = view.focal * sizes[k, [0, 2]] / np.maximum([right - left, bottom - top], 1.0)
            whole = [by for by, ends in ((by_width, (0, 2)), (by_height, (1, 3))) if not self.open[k, list(ends)].any()]
            far = float(np.mean(whole)) if whole else min(by_width, by_height)
            down = view.above - self.ground[k]
            if not self.open[k, 3] and foot[2] * down < 0:
                far = down / -foot[2] * float(np.hypot(*foot[:2])) + sizes[k, 1] / 2
            rows[k, 1] = np.log(np.clip(far, NEAREST, FARTHEST))
        return state

    def place(self, camera: Array) -> tuple[Array, Array]:
        """The best state with this camera (5,), and what each thing costs."""

        def measure(rest: Array) -> Array:
            return self.measure_deviations(np.concatenate([camera, rest]))

        start, sparsity = self.start(camera)[CAMERA:], self.sparsity[:, CAMERA:]
        fit = least_squares(measure, start, x_scale=0.1, max_nfev=STEPS_ALONE, jac_sparsity=sparsity)
        state = np.concatenate([camera, fit.x])
        return state, self.measure_costs(state)

    def improve(self, state: Array) -> tuple[Array, float]:
        """The best state near one, camera and all, and its cost."""
        fit = least_squares(self.measure_deviations, state, x_scale=0.1, max_nfev=STEPS, jac_sparsity=self.sparsity)
        return fit.x, float(fit.cost) + sum(item.penalty for item in self.items)

    def _list_dependences(self) -> csr_array:
        """Which deviation depends on which number of a state."""
        n, c = len(self.items), len(self.camera.given.guides) + LINES_BESIDE
        found = np.zeros((c + 9 * n, CAMERA + BOX * n), dtype=bool)
        found[: c + 4 * n, :CAMERA] = True
        for k in range(n):
            chain = [k, *list_carriers(self.items, k)]
            columns = [CAMERA + BOX * one + number for one in chain for number in range(BOX)]
            for first, count in ((c + 4 * k, 4), (c + 7 * n + 2 * k, 2)):
                found[first : first + count, columns] = True
            found[c + 4 * n + 3 * k : c + 4 * n + 3 * k + 3, CAMERA + BOX * k + 2 : CAMERA + BOX * (k + 1)] = True
        return csr_array(found)


def measure_camera(camera: CameraPrior, state: Array) -> Array:
    """Deviations (C,) of the camera from its lines, a usual direction, its focal length and a usual height."""
    given, view = camera.given, camera.view_of(state)
    axes = np.array([perspective.AXES.index(line.axis) for line in given.guides], dtype=int)
    ends = np.array([(line.a, line.b) for line in given.guides], dtype=float).reshape(-1, 2, 2)
    focal = (state[3] - np.log(given.likely_focal)) / given.spread
    height = (state[4] - HEIGHT[0]) / HEIGHT[1]
    lines = weigh_residuals(measure_misses(view, axes, ends))
    return np.concatenate([lines, (state[:3] - perspective.USUAL) / perspective.SURE, [focal, height]])


def list_carriers(items: Sequence[FitItem], k: int) -> list[int]:
    """The thing that a thing stands on, the one that stands on, and so on."""
    at = items[k].on
    return [at, *list_carriers(items, at)] if at >= 0 else []


class Fitted(NamedTuple):
    """The things as they fit best, the state, and its cost."""

    layout: Layout
    state: Array
    cost: float


def list_modes(item: FitItem) -> list[FitItem]:
    """What a thing may be."""
    modes = [item]
    if item.legs and item.on < 0 and not item.open[3]:
        modes.append(replace(item, open=item.open | BOTTOM, endless=True, penalty=MISSED_LEGS))
    if item.across:
        modes += [replace(one, yaw=np.pi / 4, penalty=one.penalty + ACROSS) for one in modes]
    return [replace(one, yaw=one.yaw + turn) for one in modes for turn in (0.0, np.pi / 2)]


def choose_modes(camera: CameraPrior, items: Sequence[FitItem], state: Array) -> tuple[list[FitItem], Array]:
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


def fit_things(camera: CameraPrior, items: Sequence[FitItem]) -> Fitted:
    """The best fit: the camera's height by trial, each thing in its best mode, then all together, and once more."""
    states = [np.array([*camera.state, HEIGHT[0] + HEIGHT[1] * step]) for step in FIRST_STEPS]
    totals = np.square(FIRST_STEPS) / 2 + [choose_modes(camera, items, state)[1].sum() for state in states]
    fits = list[Fitted]()
    for first in np.argsort(totals, kind="stable")[:KEPT]:
        state = states[first]
        for _ in range(ROUNDS):
            layout = Layout(camera, choose_modes(camera, items, state)[0])
            fits.append(Fitted(layout, *layout.improve(layout.place(state)[0])))
            state = fits[-1].state[:5]
    return min(fits, key=lambda fit: fit.cost)


def place_things(camera: CameraPrior, items: Sequence[FitItem], state: Array) -> Fitted:
    """The best fit with this camera (5,): each thing in its best mode."""
    layout = Layout(camera, choose_modes(camera, items, state)[0])
    placed, costs = layout.place(state)
    return Fitted(layout, placed, float(costs.sum()))


def fit_measurable(
    camera: CameraPrior, items: Mapping[int, FitItem], state: Array | None = None
) -> tuple[Fitted | None, list[int]]:
    """The best fit of the things that can be fitted, and their names; None: of no thing.

    Args:
        items: by name; what stands on one that fits nowhere stands on the floor.
        state: of the camera (5,), which then stays.
    """
    kept = list(items)
    if not kept:
        return None, []
    try:
        each = list(items.values())
        return (fit_things(camera, each) if state is None else place_things(camera, each, state)), kept
    except ODD:
        alone = np.array([*camera.state, HEIGHT[0]])
        good = list[int]()
        for name in kept:
            with suppress(*ODD):
                place_things(camera, [replace(items[name], on=-1)], alone)  # has any place on the floor
                good.append(name)
        if len(good) == len(kept):
            raise
        number = {kept.index(name): place for place, name in enumerate(good)}
        rest = {name: replace(items[name], on=number.get(items[name].on, -1)) for name in good}
        return fit_measurable(camera, rest, state)
