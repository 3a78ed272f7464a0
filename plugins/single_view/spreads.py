"""How sure the camera of a picture without depth is, and whether its lines and its things agree on its tilt."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import approx_fprime

from plugins.single_view.fit import HEIGHT, Array, CameraPrior, Layout, measure_camera

STEP = 1e-6  # of the numbers of a state, by which slopes are measured
TOGETHER = 1.3  # of the height's spread: sizes of one room err together, which the fit does not know; chosen on `work`
APART = 2.0  # spreads between the tilts by lines and by things from which on they disagree; chosen


class Spread(NamedTuple):
    """Standard deviations: of the tilt, radians; of height and focal length, as shares; 0: a person told it."""

    tilt: float
    height: float
    focal: float


def measure_spread(measure: Callable[[Array], Array], state: Array) -> Spread:
    """Spreads of the camera at the best state (5 + ...,): the inverse of J^T J, J the slopes there (Gauss-Newton).

    measure: all deviations (N,) of a state, each in its own standard deviation.
    """
    spread = np.linalg.norm(np.linalg.pinv(approx_fprime(state, measure, STEP)), axis=1)
    return Spread(tilt=float(spread[1]), height=float(TOGETHER * spread[4]), focal=float(spread[3]))


def measure_spread_of_lines(camera: CameraPrior) -> Spread:
    """Spreads of the camera by its lines, and by what is usual."""
    return measure_spread(partial(measure_camera, camera), np.array([*camera.state, HEIGHT[0]]))


def compare_tilts(layout: Layout, state: Array) -> str:
    """A sentence where the things of a fit, without any line, give another tilt than the lines do; else empty."""
    camera = layout.camera
    blind = replace(camera, given=camera.given.model_copy(update={"guides": []}))
    alone = Layout(blind, layout.items)
    things, _ = alone.improve(state)
    spread = np.hypot(measure_spread_of_lines(camera).tilt, measure_spread(alone.measure_deviations, things).tilt)
    tilts = np.array([camera.state[1], things[1]])
    if not camera.given.guides or abs(np.diff(tilts)[0]) < APART * spread:
        return ""
    lines, things_say = -np.degrees(tilts)
    return (
        f"by its lines the camera looks {lines:.0f} degrees down, by its things {things_say:.0f}: "
        "see on the page whether the lines run along walls and furniture"
    )
