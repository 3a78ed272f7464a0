"""Where the camera looks and its focal length, from lines whose direction in the room is known (least squares)."""

from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field
from scipy.optimize import least_squares

from plugins.inputs.photo.metrology import View, rotation_of
from stages.contracts.files import Contract
from stages.contracts.types import Pixel

Points = NDArray[np.float64]
Focal = Annotated[float, Field(gt=10, lt=1e5, allow_inf_nan=False)]
Axis = Literal["x", "y", "z"]
PIN = 0.3  # pixels by which what was fixed by hand may be off; of lines, one
USUAL = np.array([0.0, np.deg2rad(-8), 0.0])  # yaw, pitch and roll of a hand-held camera, and how sure that is
SURE = np.deg2rad([45.0, 15.0, 2.0])
AXES = "xyz"
WEAK = np.deg2rad(2.0)  # between a line and the direction that it should run in


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


def measure_misses(view: View, axes: NDArray[np.integer], ends: Points) -> Points:
    """Pixels (N,) by which each line's end misses the line from its middle to the vanishing point of its axis.

    Args:
        axes: (N,) 0, 1, 2 for x, y, z.
        ends: (N, 2, 2) pixels of both ends.
    """
    center = np.array([(view.width - 1) / 2, (view.height - 1) / 2])
    a, b = ends[:, 0] - center, ends[:, 1] - center
    middle = (a + b) / 2
    direction = view.rotation[axes]  # of the axis, in the camera frame
    vanishing = np.concatenate([direction[:, :2] * view.focal, direction[:, 2:]], axis=1)
    line = np.cross(np.concatenate([middle, np.ones((len(a), 1))], axis=1), vanishing)
    length = np.maximum(np.hypot(line[:, 0], line[:, 1]), 1e-9)
    return np.asarray((np.einsum("ni,ni->n", line[:, :2], a) + line[:, 2]) / length)


def find_weak_lines(view: View, guides: list[Guide]) -> list[bool]:
    """Lines that disagree with the fitted camera: they carry little weight, or are wrong."""
    ends = np.array([(line.a, line.b) for line in guides], dtype=float).reshape(-1, 2, 2)
    off = np.abs(measure_misses(view, np.array([AXES.index(line.axis) for line in guides], dtype=int), ends))
    half = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / 2
    return [bool(one) for one in off > WEAK * half]


def _measure_miss(view: View, axis: int, pixel: ArrayLike) -> Points:
    """By how many pixels a vanishing point misses the place where it was put; it may be at infinity."""
    center = np.array([(view.width - 1) / 2, (view.height - 1) / 2])
    wanted = np.array([*(np.asarray(pixel, dtype=float) - center) / view.focal, 1.0])
    wanted /= np.linalg.norm(wanted)
    return np.asarray(np.cross(wanted, view.rotation[axis]) * view.focal)


def horizon(view: View) -> tuple[Pixel, Pixel]:
    """The horizon's pixels at the left and right border of the picture."""
    up = view.rotation[2]  # in the camera frame: its plane is the horizon
    center = [(view.width - 1) / 2, (view.height - 1) / 2]
    down = up[1] if abs(up[1]) > 1e-3 else np.copysign(1e-3, up[1])
    ends = []
    for u in (0.0, view.width - 1.0):
        v = center[1] - (up[0] * (u - center[0]) + up[2] * view.focal) / down
        ends.append((u, float(np.clip(v, -1e5, 1e5))))
    return ends[0], ends[1]


def vanishing_point(view: View, axis: int) -> Pixel | None:
    """The pixel where lines along an axis meet; None if that is far outside."""
    x, y, z = view.rotation[axis]
    if abs(z) < 0.02:
        return None
    return float(x / z * view.focal + (view.width - 1) / 2), float(y / z * view.focal + (view.height - 1) / 2)


@lru_cache(maxsize=64)
def _fit(width: int, height: int, text: str, start: tuple[float, float, float] | None) -> View:
    given = Perspective.model_validate_json(text)
    axes = np.array([AXES.index(line.axis) for line in given.guides], dtype=int)
    ends = np.array([(line.a, line.b) for line in given.guides], dtype=float).reshape(-1, 2, 2)
    focal, spread = (given.focal, PIN / given.focal) if given.focal else (given.likely_focal, given.spread)
    pins = [(AXES.index(name), pixel) for name in "xyz" if (pixel := getattr(given, name)) is not None]

    def view_of(state: Points) -> View:
        return View(width, height, float(np.exp(np.clip(state[3], 2, 12))), rotation_of(*state[:3]))

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
    """Residuals under Cauchy's loss, so that a few lines of turned furniture do not tilt the room."""
    return np.asarray(np.sign(values) * np.sqrt(np.log1p(values**2)))


def fit_view(given: Perspective, width: int, height: int, start: tuple[float, float, float] | None = None) -> View:
    """The camera, one metre above the floor, that explains the lines best; usual values where they leave it open.

    Args:
        given: lines and what was fixed by hand.
        start: yaw, pitch and roll to begin with, if they are roughly known; else several are tried.
    """
    return _fit(width, height, given.model_dump_json(), start)
