"""The room of a picture without depth: camera and how sure it is, walls, and a box for everything that has a place."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import approx_fprime

from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception.camera.metrology import PinholeView, UprightPlane
from roomkin.stages.perception.camera.perspective import Perspective, fit_view, propose, usual_focal
from roomkin.stages.perception.classification.names import UNMEASURED
from roomkin.stages.perception.layout.ends import NOWHERE, WALL, Kind, Mask, list_items
from roomkin.stages.perception.layout.fit import (
    HEIGHT,
    Array,
    CameraPrior,
    Fitted,
    Layout,
    fit_measurable,
    measure_camera,
)
from roomkin.stages.perception.layout.walls import hang_things

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
    told = f"by its lines the camera looks {lines:.0f} degrees down, by its things {things_say:.0f}"
    return f"{told}: see on the page whether the lines run along walls and furniture"


@dataclass(frozen=True)
class Arrangement:
    """What stands in a picture, fitted with its camera.

    fitted: None where nothing stands: the camera is a usual one. values: of the masks of the things in it.
    on: what each thing stands on: the value of a mask, or `FLOOR`, `WALL`, `NOWHERE`; kinds: what each is.
    odd: things that fit nowhere.
    """

    camera: CameraPrior
    fitted: Fitted | None
    values: list[int]
    on: dict[int, int]
    kinds: dict[int, Kind]
    odd: set[int]

    @property
    def state(self) -> Array:
        """Of the camera (5,), as `Layout` has it."""
        return np.array([*self.camera.state, HEIGHT[0]]) if self.fitted is None else self.fitted.state[:5]

    @property
    def view(self) -> PinholeView:
        """The camera."""
        if self.fitted is None:
            return replace(self.camera.view, above=float(np.exp(HEIGHT[0])))
        return self.camera.view_of(self.fitted.state)

    @property
    def boxes(self) -> dict[int, UprightBox]:
        """By the values of masks."""
        found = self.fitted.layout.list_boxes(self.fitted.state) if self.fitted else []
        return dict(zip(self.values, found, strict=True))


@dataclass(frozen=True)
class FittedRoom:
    """A room: the lines that the camera follows, the camera, walls, boxes by the values of their masks.

    spread: of the camera. doubt: a sentence where lines and things disagree about it.
    on: what each thing stands or hangs on: the value of a mask, 0 (floor), or -1 - k for wall k.
    left_out: why other things have no place.
    """

    perspective: Perspective
    view: PinholeView
    spread: Spread
    doubt: str
    walls: list[UprightPlane]
    boxes: dict[int, UprightBox]
    on: dict[int, int]
    left_out: dict[int, str] = field(default_factory=dict)


def see_camera(rgb: NDArray[np.uint8], focal: float | None) -> CameraPrior:
    """What the lines of a picture (H, W, 3) tell of its camera; focal: pixels, if EXIF or a person tells it."""
    height, width = rgb.shape[:2]
    known = usual_focal(width, height, focal)
    given = known.model_copy(update={"guides": propose(rgb, known).guides})
    return CameraPrior(given, fit_view(given, width, height))


def arrange(
    camera: CameraPrior,
    masks: NDArray[np.integer],
    labels: Mapping[int, str],
    inside: Mask,
    seen_by: Arrangement | None = None,
) -> Arrangement:
    """What stands in a picture.

    Args:
        masks: (H, W).
        labels: of the things, by the values of their masks; of none the camera is a usual one.
        inside: (H, W) pixels that show something: no frame around the picture.
        seen_by: whose camera stays; None: the camera is fitted, too.
    """
    items, on, kinds = list_items(masks, labels, inside)
    fitted, values = fit_measurable(camera, items, seen_by.state if seen_by else None)
    return Arrangement(camera, fitted, values, on, kinds, odd=items.keys() - set(values))


def build_room(
    rgb: NDArray[np.uint8], arranged: Arrangement, masks: NDArray[np.integer], seen_by: Arrangement | None = None
) -> FittedRoom:
    """The room that a picture (H, W, 3) shows: what stands there, walls, and what hangs on them.

    Args:
        arranged: what stands there.
        masks: (H, W).
        seen_by: whose camera that is; None: its own.
    """
    camera, fitted = arranged.camera, (seen_by or arranged).fitted
    spread, doubt = measure_spread_of_lines(camera), ""
    if fitted is not None:
        spread = measure_spread(fitted.layout.measure_deviations, fitted.state)
        doubt = compare_tilts(fitted.layout, fitted.state)
    boxes, on = arranged.boxes, arranged.on
    walls, hanging, holders = hang_things(rgb, arranged.view, masks, arranged.kinds, on, boxes)
    hung = [value for value in on if on[value] == WALL]
    left_out = {value: "no wall that it hangs on is found" for value in hung if value not in hanging}
    left_out |= {value: "what it stands on is not seen" for value in on if on[value] == NOWHERE}
    left_out |= dict.fromkeys(arranged.odd, UNMEASURED)
    on = {value: holders.get(value, on[value]) for value in [*boxes, *hanging]}
    return FittedRoom(camera.given, arranged.view, spread, doubt, walls, boxes | hanging, on, left_out)


def scale_room(room: FittedRoom, labels: Mapping[int, str], heights: Mapping[str, float]) -> FittedRoom:
    """The room, as large as the heights say, metres, that a person knows of things by label, or of the `camera`."""
    factors = [heights["camera"] / room.view.above] if "camera" in heights else []
    factors += [heights[labels[value]] / box.size[2] for value, box in room.boxes.items() if labels[value] in heights]
    if not factors:
        return room
    factor = float(np.median(factors))
    walls = [UprightPlane(wall.normal, factor * wall.offset) for wall in room.walls]
    boxes = {value: UprightBox(factor * box.center, factor * box.size, box.yaw) for value, box in room.boxes.items()}
    view, spread = replace(room.view, above=factor * room.view.above), room.spread._replace(height=0.0)
    return replace(room, view=view, spread=spread, walls=walls, boxes=boxes)


def tell_camera(room: FittedRoom) -> str:
    """The camera, each number with its spread (one standard deviation), for people."""
    view, spread = room.view, room.spread
    down = float(np.degrees(np.arcsin(-view.rotation[2, 2])))
    height = f" (± {spread.height * view.above:.2f})" if spread.height else ""
    told = (
        f"the camera is {view.above:.2f} m{height} above the floor and looks {down:.1f} degrees "
        f"(± {np.degrees(spread.tilt):.1f}) down, its focal length is {view.focal:.0f} pixels "
        f"(± {spread.focal * view.focal:.0f})"
    )
    return "; ".join(filter(None, [told, room.doubt]))
