"""Candidates laid over an object in every way that it may stand (paper B.1), rendered and compared term by term."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from roomkin.plugins.render_and_compare import observation
from roomkin.plugins.render_and_compare.observation import NoisyCloud, ObservedGrid
from roomkin.plugins.render_and_compare.package import GeometryConfig
from roomkin.plugins.render_and_compare.rendering import ColoredSolid, Rendering, render
from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import SYMMETRY_PERIOD, view_angle, view_yaw, wrap_angle, yaw_matrix
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.geometry.robust import BIN, LARGEST_CHANGE, REACH, TRIM, UNUSUAL, Deviations, find_step
from roomkin.stages.matching.descriptors import LIGHTNESS

OUTERMOST = 2.0  # deviations of noise by which these lie beyond a face; chosen
SEEN, UNSEEN = 0.1, 0.3  # of an extent: deviation of any face, and how much more of the hidden one; chosen
ROUNDS = 4  # of Gauss-Newton steps; chosen for time
SIDE_ERROR = 0.005  # of the object's longer side in the picture: how well outlines meet; chosen
STRETCH = 0.5  # deviation of the logarithm of one axis' scale over another's ...
TURNED = 0.05  # ... and of the two level ones, if a quarter turn maps the model onto itself; chosen
Floats = NDArray[np.float64]


class Measured(NamedTuple):
    """Ends (2, 3) of what is seen of an object along axes turned by `yaw`, and how far each may be wrong, metres."""

    ends: Floats
    errors: Floats
    yaw: float

    def box(self) -> UprightBox:
        """The box between the ends."""
        size = np.maximum(self.ends[1] - self.ends[0], BIN)
        return UprightBox(yaw_matrix(self.yaw) @ self.ends.mean(axis=0), size, self.yaw)


def measure(sight: NoisyCloud, box: UprightBox, yaw: float, wall: tuple[Floats, float] | None = None) -> Measured:
    """The extents of an object along axes turned by `yaw`, with the heights of its box.

    Args:
        box: the minimum box of its points, down to what it stands on.
        wall: normal (3,) and offset of the wall that the object reaches to, further than its points may tell.
    """
    turn = yaw_matrix(yaw)[:2, :2]
    level = sight.measure_ends(yaw, TRIM, OUTERMOST)
    ends = np.column_stack([level, [box.bottom, box.top]])
    extent = np.maximum(ends[1] - ends[0], BIN)
    along, noise = np.append(sight.ray[:2] @ turn, 0.0), np.append(sight.noise_along(yaw), 0.0)
    errors = (SEEN + UNSEEN * np.clip([-along, along], 0, 1)) * extent + OUTERMOST * noise
    if wall is not None:
        normal = wall[0][:2] @ turn
        axis = int(np.argmax(np.abs(normal)))
        end = 0 if normal[axis] > 0 else 1
        there = wall[1] * np.sign(normal[axis])
        errors[end, axis] = SEEN * extent[axis] + abs(there - ends[end, axis]) / 2
        ends[end, axis] = there
    order = np.argsort(ends, axis=0)  # the wall may stand before the near end
    return Measured(np.take_along_axis(ends, order, axis=0), np.take_along_axis(errors, order, axis=0), yaw)


def lay_over(solid: ColoredSolid, measured: Measured, seen: ObservedGrid) -> UprightBox:
    """The box whose outline in the picture reaches the sides of the mask, near the measured one.

    Gauss-Newton over place and logarithms of the extents, with Cauchy's weights. Three kinds of residuals: sides of
    the outline against those of the mask (neither hidden nor cut off), ends against the measured ones, and scales of
    the axes against each other, which keep the model's proportions where nothing else decides.
    """
    turn, start = yaw_matrix(measured.yaw), measured.box()
    center, size = measured.ends.mean(axis=0), start.size
    longer = float(np.max(seen.sides[2:] - seen.sides[:2]))
    native = np.maximum(solid.asset.size, BIN)
    level = TURNED if SYMMETRY_PERIOD[solid.asset.symmetry] < np.pi else STRETCH

    def compare(change: Floats) -> Deviations:
        middle, extents = center + change[:3] * size, size * np.exp(change[3:])
        pixels = seen.project(solid.place_outline(UprightBox(turn @ middle, extents, measured.yaw)))
        sides = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
        off = (sides - seen.sides)[seen.free] / longer
        ends = np.array([middle - extents / 2, middle + extents / 2])
        x, y, z = np.log(extents / native)
        stretch = [(x - y) / level, (z - (x + y) / 2) / STRETCH]
        terms = np.concatenate([off / SIDE_ERROR, ((ends - measured.ends) / measured.errors).ravel(), stretch])
        return Deviations(terms, np.ones(len(terms)), np.full(len(terms), UNUSUAL))

    change = np.zeros(6)
    for _ in range(ROUNDS):
        step, _ = find_step(compare, change, 1e-3, np.zeros(6))
        change = (change - step).clip(-LARGEST_CHANGE, LARGEST_CHANGE)
    return UprightBox(turn @ (center + change[:3] * size), size * np.exp(change[3:]), measured.yaw)


DEPTH_SCALE = 0.06  # of the diagonal, beyond the noise of depth: a difference that counts as wholly wrong; chosen
LINE_DIRECTIONS, LINE_BLUR, LINE_WINDOW = 6, 1.2, 4.0  # of half a turn; cells: lines may be off, are compared within
FAINTEST_LINE = 0.1  # lines weaker than this are noise; chosen
COLOR_SCALE = 0.3  # of Lab / 100: a difference that counts as wholly wrong; chosen
Array = NDArray[np.float32]


class Terms(NamedTuple):
    """Agreement in [0, 1], 1 best, but for `proportions`: how unlike the stretches of the three axes are, 0 best."""

    outline: float
    depth: float
    lines: float
    colour: float
    proportions: float


def compare(seen: ObservedGrid, shown: Rendering, size: ArrayLike, native: ArrayLike, given: Array) -> Terms:
    """Compare a candidate of extents `size` (3,), `native` in the library; `given`: `line_field` of the object."""
    covered = shown.cover >= 0.5
    both = seen.mask & covered
    known = both & (seen.depth > 0)
    if not known.any():
        return Terms(0, 0, 0, 0, distortion(size, native))
    ratio = float(np.median(seen.depth[known] / shown.depth[known]))  # the fit's distance, and the error of depth's
    outline = outline_agreement(seen, shown, ratio)
    tolerance = DEPTH_SCALE * np.linalg.norm(np.asarray(size)) + REACH * seen.depth_error.predict(seen.depth[known])
    off = np.abs(seen.depth[known] - ratio * shown.depth[known]) / tolerance
    shared = erode_mask(both) if erode_mask(both).any() else both
    return Terms(
        outline,
        1 - float(np.minimum(off, 1).mean()),
        line_agreement(given, line_field(shown.plain), shared),
        color_agreement(seen.rgb[both], shown.rgb[both]),
        distortion(size, native),
    )


def outline_agreement(seen: ObservedGrid, shown: Rendering, ratio: float) -> float:
    """Intersection over union of the outlines, over the cells where the candidate could be seen."""
    visible = ~((shown.cover > 0) & seen.find_hidden(shown.depth * ratio))
    mask = seen.mask.astype(np.float32)
    union = np.maximum(mask, shown.cover)[visible].sum()
    return float(np.minimum(mask, shown.cover)[visible].sum() / union) if union else 0.0


def erode_mask(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells that do not lie at the outline."""
    return cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0


def line_field(rgb: Array) -> Array:
    """Gradients (h, w, 2) of a picture, x and y, in the Lab channel that changes most; compressed."""
    lab = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2LAB) / 100
    field = np.zeros((*lab.shape, 2), np.float32)
    field[:, 1:-1, :, 0] = (lab[:, 2:] - lab[:, :-2]) / 2
    field[1:-1, :, :, 1] = (lab[2:] - lab[:-2]) / 2
    strength = np.linalg.norm(field, axis=-1)
    chosen = strength.argmax(axis=-1)[..., None]
    strongest = np.take_along_axis(field, chosen[..., None], axis=2)[:, :, 0]
    return strongest / np.sqrt(np.maximum(np.take_along_axis(strength, chosen, axis=2), 1e-12))


def line_agreement(given: Array, shown: Array, where: NDArray[np.bool_]) -> float:
    """Mean agreement of two line fields around each cell, by direction, whichever side of a line is the darker one.

    As in structural similarity: twice the product over the squares' sum, over a window; 1 where neither has lines.
    """
    a, b = _by_direction(given, where), _by_direction(shown, where)
    product = cv2.GaussianBlur((a * b).sum(axis=-1), (0, 0), LINE_WINDOW)
    squares = cv2.GaussianBlur((a * a + b * b).sum(axis=-1), (0, 0), LINE_WINDOW)
    agreement = (2 * product + FAINTEST_LINE**2) / (squares + FAINTEST_LINE**2)
    return float(agreement[where].mean())


def _by_direction(field: Array, where: NDArray[np.bool_]) -> Array:
    """Strengths (h, w, LINE_DIRECTIONS) of lines by direction, each spread over the cells by which it may be off."""
    strength = np.linalg.norm(field, axis=-1) * where
    at = np.arctan2(field[..., 1], field[..., 0]) % np.pi / np.pi * LINE_DIRECTIONS
    below = np.floor(at).astype(int)
    share = at - below
    channels = np.zeros((*where.shape, LINE_DIRECTIONS), np.float32)
    rows, columns = np.arange(where.shape[0])[:, None], np.arange(where.shape[1])
    channels[rows, columns, below % LINE_DIRECTIONS] = strength * (1 - share)
    channels[rows, columns, (below + 1) % LINE_DIRECTIONS] += strength * share
    return np.asarray(cv2.GaussianBlur(channels, (0, 0), LINE_BLUR), np.float32)


def color_agreement(given: Array, shown: Array) -> float:
    """Agreement of colors (N, 3); the lightness of the whole does not count, nor does half of that of its parts."""
    a, b = (cv2.cvtColor(np.ascontiguousarray(rgb[None]), cv2.COLOR_RGB2LAB)[0] / 100 for rgb in (given, shown))
    off = a - b
    off[:, 0] = LIGHTNESS * (off[:, 0] - np.median(off[:, 0]))
    return 1 - float(np.minimum(np.linalg.norm(off, axis=1) / COLOR_SCALE, 1).mean())


def distortion(size: ArrayLike, native: ArrayLike) -> float:
    """Range of the logarithms of the three axes' scales: 0 if the model keeps its proportions."""
    return float(np.ptp(np.log(np.maximum(np.asarray(size), 1e-4) / np.maximum(np.asarray(native), 1e-4))))


SAME_YAW = np.deg2rad(2)  # ways to stand that differ by less are one; chosen


class Fit(NamedTuple):
    """A candidate in the object's place. yaw: of the view, as in cousins.json; box: floor frame."""

    asset: str
    yaw: float
    box: UprightBox
    picture: Rendering
    terms: Terms

    def score(self, weights: GeometryConfig) -> float:
        """Weighted sum of the terms: more is better."""
        agreement = sum(getattr(weights, name) * getattr(self.terms, name) for name in Terms._fields[:-1])
        return float(agreement - weights.proportions * self.terms.proportions)


class Fitter:
    """Fits models of a library to one object that has depth, intrinsics and a box."""

    def __init__(self, view: ObjectView, item: SceneObject, scene: Objects, resolution: int) -> None:
        assert item.box is not None
        self.box = UprightBox(item.box.center, item.box.size, item.box.yaw)
        self.seen = observation.observe(
            view, np.array(scene.floor_from_camera, dtype=float), scene.depth_error, resolution
        )
        self.lines = line_field(self.seen.rgb)
        self.sight = NoisyCloud(self.seen.cloud, self.seen.eye, scene.depth_error.predict)
        walls = observation.touched_walls(item, scene)
        self.wall = (np.array(walls[0].normal), walls[0].offset) if walls else None
        self._measured: dict[float, Measured] = {}
        self._fits: dict[tuple[str, float], Fit] = {}
        self.front_known = observation.is_front_known(item, scene)
        self.aligned = observation.aligned_yaws(item, scene)

    def fit(self, solid: ColoredSolid, yaws: Sequence[float]) -> list[Fit]:
        """The model at several yaws of the floor frame, those left out that its symmetry makes equal."""
        return [self._fit(solid, yaw) for yaw in leave_out_equal(yaws, SYMMETRY_PERIOD[solid.asset.symmetry])]

    def _fit(self, solid: ColoredSolid, yaw: float) -> Fit:
        known = self._fits.get((solid.asset.id, yaw))
        if known is not None:
            return known
        box = self.box_of(solid, yaw)
        picture = render(solid, box, self.seen)
        terms = compare(self.seen, picture, box.size, solid.asset.size, self.lines)
        fit = Fit(solid.asset.id, view_angle(self.seen.eye, self.box.center, yaw), box, picture, terms)
        self._fits[solid.asset.id, yaw] = fit
        return fit

    def box_of(self, solid: ColoredSolid, yaw: float) -> UprightBox:
        """The box of a model that stands at a yaw of the floor frame in the object's place."""
        if yaw not in self._measured:
            self._measured[yaw] = measure(self.sight, self.box, yaw, self.wall)
        return lay_over(solid, self._measured[yaw], self.seen)

    def floor_yaw(self, view: float) -> float:
        """Yaw in the floor frame of a model that is seen at the yaw of a view."""
        return view_yaw(self.seen.eye, self.box.center, view)


def leave_out_equal(yaws: Sequence[float], period: float) -> list[float]:
    """The yaws, but those that equal an earlier one modulo the period (0: all are equal)."""
    kept: list[float] = []
    for yaw in yaws:
        if not kept or (period and all(abs(wrap_angle(yaw - other, period)) > SAME_YAW for other in kept)):
            kept.append(yaw)
    return kept
