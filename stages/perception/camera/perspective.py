"""Where the camera looks and its focal length, from lines whose direction in the room is known (least squares)."""

from functools import lru_cache
from typing import Annotated, Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field
from scipy.optimize import least_squares

from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.types import Pixel
from roomkin.stages.geometry.frames import rotation_of, wrap_angle
from roomkin.stages.perception.camera.metrology import PinholeView

Points = NDArray[np.float64]
Focal = Annotated[float, Field(gt=10, lt=1e5, allow_inf_nan=False)]
Axis = Literal["x", "y", "z"]
PIN = 0.3  # pixels by which what was fixed by hand may be off; of lines, one
USUAL = np.array([0.0, np.deg2rad(-8), 0.0])  # yaw, pitch and roll of a hand-held camera, and how sure that is
SURE = np.deg2rad([45.0, 15.0, 2.0])
AXES = "xyz"
WEAK = np.deg2rad(2.0)  # between a line and the direction that it should run in
MOST = 200  # segments, the longest: as many as a drawing may have
HYPOTHESES = 400  # per focal length
TRIALS = np.linspace(-3, 3, 9)  # focal lengths, in standard deviations from the likely one
PRIOR = 0.02  # share of agreeing length that one standard deviation of the focal length is worth
GUIDES_SHOWN = 5  # guides per axis
FITS = 0.9  # agreement of a segment that is shown: two thirds of a degree
USUAL_FOCAL = 0.8  # of the longer side: 64 degrees across
KNOWN_SPREAD = 0.03  # of the logarithm of a focal length from EXIF


class Guide(Contract):
    """A line in the picture that in the room runs along an axis: x along the view's wall, y away from us, z up."""

    axis: Axis
    a: Pixel
    b: Pixel


class Perspective(Contract):
    """What determines the camera: lines, and values fixed by hand (null: fitted to the lines)."""

    guides: list[Guide] = Field([], max_length=200)
    horizon: tuple[Pixel, Pixel] | None = None
    x: Pixel | None = None
    y: Pixel | None = None
    z: Pixel | None = None
    focal: Focal | None = Field(None, description="pixels, fixed by hand")
    likely_focal: Focal = Field(description="pixels: from EXIF, from all lines found, or that of a usual camera")
    spread: float = Field(0.3, gt=0, le=2, description="standard deviation of the logarithm of `likely_focal`")


def measure_misses(view: PinholeView, axes: NDArray[np.integer], ends: Points) -> Points:
    """Pixels (N,) by which each line's end misses the line from its middle to the vanishing point of its axis.

    Args:
        axes: (N,) 0, 1, 2 for x, y, z.
        ends: (N, 2, 2) pixels of both ends.
    """
    a, b = ends[:, 0] - view.center, ends[:, 1] - view.center
    middle = (a + b) / 2
    direction = view.rotation[axes]  # of the axis, in the camera frame
    vanishing = np.concatenate([direction[:, :2] * view.focal, direction[:, 2:]], axis=1)
    line = np.cross(np.concatenate([middle, np.ones((len(a), 1))], axis=1), vanishing)
    length = np.maximum(np.hypot(line[:, 0], line[:, 1]), 1e-9)
    return np.asarray((np.einsum("ni,ni->n", line[:, :2], a) + line[:, 2]) / length)


def find_weak_lines(view: PinholeView, guides: list[Guide]) -> list[bool]:
    """Lines that disagree with the fitted camera: they carry little weight, or are wrong."""
    ends = np.array([(line.a, line.b) for line in guides], dtype=float).reshape(-1, 2, 2)
    off = np.abs(measure_misses(view, np.array([AXES.index(line.axis) for line in guides], dtype=int), ends))
    half = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / 2
    return [bool(one) for one in off > WEAK * half]


def _measure_miss(view: PinholeView, axis: int, pixel: ArrayLike) -> Points:
    """By how many pixels a vanishing point misses the place where it was put; it may be at infinity."""
    wanted = np.array([*(np.asarray(pixel, dtype=float) - view.center) / view.focal, 1.0])
    wanted /= np.linalg.norm(wanted)
    return np.asarray(np.cross(wanted, view.rotation[axis]) * view.focal)


def horizon(view: PinholeView) -> tuple[Pixel, Pixel]:
    """The horizon's pixels at the left and right border of the picture."""
    up = view.rotation[2]  # in the camera frame: its plane is the horizon
    (across, middle), ends = view.center, []
    down = up[1] if abs(up[1]) > 1e-3 else np.copysign(1e-3, up[1])
    for u in (0.0, view.width - 1.0):
        v = middle - (up[0] * (u - across) + up[2] * view.focal) / down
        ends.append((u, float(np.clip(v, -1e5, 1e5))))
    return ends[0], ends[1]


def vanishing_point(view: PinholeView, axis: int) -> Pixel | None:
    """The pixel where lines along an axis meet; None if that is far outside."""
    x, y, z = view.rotation[axis]
    if abs(z) < 0.02:
        return None
    return float(x / z * view.focal + view.center[0]), float(y / z * view.focal + view.center[1])


@lru_cache(maxsize=64)
def _fit(text: str, width: int, height: int, start: tuple[float, float, float] | None) -> PinholeView:
    given = Perspective.model_validate_json(text)
    axes = np.array([AXES.index(line.axis) for line in given.guides], dtype=int)
    ends = np.array([(line.a, line.b) for line in given.guides], dtype=float).reshape(-1, 2, 2)
    focal, spread = (given.focal, PIN / given.focal) if given.focal else (given.likely_focal, given.spread)
    pins = [(AXES.index(name), pixel) for name in "xyz" if (pixel := getattr(given, name)) is not None]

    def view_of(state: Points) -> PinholeView:
        return PinholeView(width, height, float(np.exp(np.clip(state[3], 2, 12))), rotation_of(*state[:3]))

    def residuals(state: Points) -> Points:
        view = view_of(state)
        parts = [weigh_residuals(measure_misses(view, axes, ends))]
        parts += [_measure_miss(view, axis, pixel) / PIN for axis, pixel in pins]
        if given.horizon is not None:
            (u0, v0), (u1, v1) = given.horizon
            (a0, b0), (a1, b1) = horizon(view)
            slope = (b1 - b0) / (a1 - a0)
            parts.append(np.array([b0 + slope * (u0 - a0) - v0, b0 + slope * (u1 - a0) - v1]) / PIN)
        parts += [(state[:3] - USUAL) / SURE, np.array([(state[3] - np.log(focal)) / spread])]
        return np.concatenate(parts)

    starts = [start] if start else [(yaw, USUAL[1], 0.0) for yaw in np.deg2rad([-40, -15, 0, 15, 40])]
    fits = [least_squares(residuals, [*first, np.log(focal)], x_scale=0.1) for first in starts]
    return view_of(min(fits, key=lambda fit: float(fit.cost)).x)


def weigh_residuals(values: Points) -> Points:
    """Residuals (...) whose squares are Cauchy's loss: a few lines of turned furniture do not tilt the room."""
    return np.asarray(np.sign(values) * np.sqrt(np.log1p(values**2)))


def fit_view(
    given: Perspective, width: int, height: int, start: tuple[float, float, float] | None = None
) -> PinholeView:
    """The camera, one metre above the floor, that explains the lines best; usual values where they leave it open.

    Args:
        given: lines and what was fixed by hand.
        start: yaw, pitch and roll to begin with, if they are roughly known; else several are tried.
    """
    return _fit(given.model_dump_json(), width, height, start)


def usual_focal(width: int, height: int, exif: float | None) -> Perspective:
    """A perspective of which only the focal length is known: the one (pixels) that EXIF tells, or a usual camera's."""
    if exif is not None:
        return Perspective(likely_focal=exif, spread=KNOWN_SPREAD)
    return Perspective(likely_focal=USUAL_FOCAL * max(width, height))


def find_segments(rgb: NDArray[np.uint8]) -> Points:
    """The longest line segments (N, 2, 2) of a picture (H, W, 3), longest first."""
    found = cv2.createLineSegmentDetector().detect(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY))[0]
    if found is None:
        return np.zeros((0, 2, 2))
    ends = np.asarray(found, dtype=float).reshape(-1, 2, 2)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return ends[np.argsort(-lengths, kind="stable")[:MOST]]


def _planes(ends: Points, width: int, height: int, focal: float) -> Points:
    """Unit normals (N, 3), camera frame, of the planes through the camera and each segment."""
    flat = (ends - [(width - 1) / 2, (height - 1) / 2]) / focal
    rays = np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1)
    normals = np.cross(rays[:, 0], rays[:, 1])
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))


def _hypotheses(normals: Points, weights: Points, highest: float, rng: np.random.Generator) -> Points:
    """room_from_camera rotations (M, 3, 3): two segments meet in one vanishing point, a third runs square to it.

    highest: pitch from which on the picture shows no floor: then nothing could be drawn.
    """
    first, second, third = rng.choice(len(normals), size=(3, HYPOTHESES), p=weights / weights.sum())
    one = np.cross(normals[first], normals[second])
    two = np.cross(normals[third], one)
    lengths = np.linalg.norm(one, axis=1), np.linalg.norm(two, axis=1)
    good = (lengths[0] > 1e-4) & (lengths[1] > 1e-4)
    one, two = one[good] / lengths[0][good, None], two[good] / lengths[1][good, None]
    frames = np.stack([one, two, np.cross(one, two)], axis=1)
    upright = np.argmax(np.abs(frames[:, :, 1]), axis=1)  # z is the axis nearest to the picture's upright
    rows = np.arange(len(frames))
    up = frames[rows, upright] * -np.sign(frames[rows, upright, 1])[:, None]
    away = np.argmax(np.where(np.arange(3) == upright[:, None], -1, np.abs(frames[:, :, 2])), axis=1)
    back = frames[rows, away] * np.sign(frames[rows, away, 2])[:, None]
    rotations = np.stack([np.cross(back, up), back, up], axis=1)
    return np.asarray(rotations[up[:, 2] < np.sin(highest)])


def _agreement(view_misses: Points, half: Points) -> Points:
    """1 where a segment points to its vanishing point, 0 where it is off by `WEAK` or more."""
    return np.clip(1 - (np.abs(view_misses) / np.maximum(half, 1e-9) / WEAK) ** 2, 0, None)


def _scores(ends: Points, lengths: Points, focal: float, size: tuple[int, int], rotations: Points) -> Points:
    """Share (M,) of the segments' length that agrees with one of the three axes."""
    center = np.array([(size[0] - 1) / 2, (size[1] - 1) / 2])
    middle, half = ends.mean(axis=1) - center, (ends[:, 1] - ends[:, 0]) / 2
    total = np.zeros((len(rotations), len(ends)))
    for axis in range(3):
        direction = rotations[:, axis]
        towards = direction[:, None, :2] * focal - direction[:, None, 2:] * middle
        off = np.abs(towards[..., 0] * half[:, 1] - towards[..., 1] * half[:, 0])
        off /= np.maximum(np.linalg.norm(towards, axis=-1), 1e-9)
        total = np.maximum(total, _agreement(off, lengths / 2))
    return np.asarray(total @ lengths / lengths.sum())


def angles_of(rotation: Points) -> tuple[float, float, float]:
    """Yaw, pitch and roll, of which `rotation_of` makes room_from_camera."""
    up, forward = rotation[2], rotation[:, 2]
    yaw = float(np.arctan2(-forward[0], forward[1]))
    return wrap_angle(yaw, np.pi), float(np.arcsin(np.clip(up[2], -1, 1))), float(np.arctan2(-up[0], -up[1]))


def _assign_axes(view: PinholeView, ends: Points) -> tuple[NDArray[np.integer], Points]:
    """Axis (N,) of each segment and how well it agrees with it."""
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    every = [measure_misses(view, np.full(len(ends), axis), ends) for axis in range(3)]
    agreements = np.stack([_agreement(off, lengths / 2) for off in every])
    return np.argmax(agreements, axis=0), agreements.max(axis=0)


def _guides(ends: Points, axes: NDArray[np.integer]) -> list[Guide]:
    """Segments (N, 2, 2) as guides along their axes (N,)."""
    lines = zip(axes, ends.tolist(), strict=True)
    return [Guide(axis=AXES[axis], a=tuple(a), b=tuple(b)) for axis, (a, b) in lines]  # type: ignore[arg-type]


def propose(rgb: NDArray[np.uint8], prior: Perspective) -> Perspective:
    """Guides along the three axes of the room, and the focal length that fits all segments of a picture (H, W, 3).

    Without lines that agree there are no guides, and the camera is the usual one: `prior`.
    """
    height, width = rgb.shape[:2]
    ends = find_segments(rgb)
    if len(ends) < 6:
        return prior
    rng = np.random.default_rng(0)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    best, best_score = None, 0.0
    for focal in (prior.likely_focal * np.exp(prior.spread * TRIALS)).tolist():
        highest = float(np.arctan(height / 2 / focal))
        rotations = _hypotheses(_planes(ends, width, height, focal), lengths, highest, rng)
        if not len(rotations):
            continue
        scores = _scores(ends, lengths, focal, (width, height), rotations)
        scores -= PRIOR * (np.log(focal / prior.likely_focal) / prior.spread) ** 2
        if scores.max() > best_score:
            best, best_score = (rotations[int(np.argmax(scores))], focal), float(scores.max())
    if best is None:
        return prior
    view = PinholeView(width, height, best[1], best[0])
    for _ in range(3):  # better lines give a better camera, which gives better lines
        axes, good = _assign_axes(view, ends)
        every = _guides(ends[good > 0], axes[good > 0])
        view = fit_view(prior.model_copy(update={"guides": every}), width, height, angles_of(view.rotation))
    axes, good = _assign_axes(view, ends)
    longest = [np.flatnonzero((axes == axis) & (good > FITS))[:GUIDES_SHOWN] for axis in range(3)]
    guides = _guides(np.round(ends, 1), axes)
    shown = [guides[number] for number in np.concatenate(longest)]
    return Perspective(guides=shown, likely_focal=view.focal, spread=min(prior.spread, 0.1))
