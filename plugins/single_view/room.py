"""The room of a picture without depth: camera, walls, and a box for everything that has a place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.annotator.solve import FLAT_DEPTH, usual_depth
from plugins.eyes.proposal import find_border
from plugins.inputs.photo.metrology import View, WallPlane, hang_box
from plugins.inputs.photo.perspective import Perspective, fit_view
from plugins.inputs.photo.segments import find_segments, propose, usual_focal
from plugins.single_view.ends import Ends, measure_all
from plugins.single_view.fit import HEIGHT, CameraPrior, Item, Usual
from plugins.single_view.modes import fit_things
from plugins.single_view.spreads import Spread, compare_tilts, measure_spread, measure_spread_of_lines
from plugins.single_view.supports import LEGGED, NOWHERE, WALL, category_of, find_open, find_supports
from plugins.single_view.walls import AGAINST, find_wall, measure_rectangle
from stages.contracts.category import Category
from stages.geometry.boxes import UprightBox

Array = NDArray[np.float64]
UNKNOWN = Usual(np.log([0.5, 0.5, 0.6]), 0.7**2 * np.eye(3))  # of a thing that has no name; chosen
NORMALS = np.array([(0.0, -1, 0), (1, 0, 0), (-1, 0, 0)])  # of the walls: the far one, that to the left, to the right


@dataclass(frozen=True)
class Room:
    """A room: the lines that the camera follows, the camera, walls, boxes by the values of their masks.

    spread: of the camera. doubt: a sentence where lines and things disagree about it.
    on: what each thing stands or hangs on: the value of a mask, 0 (floor), or -1 - k for wall k.
    left_out: why other things have no place.
    """

    perspective: Perspective
    view: View
    spread: Spread
    doubt: str
    walls: list[WallPlane]
    boxes: dict[int, UprightBox]
    on: dict[int, int]
    left_out: dict[int, str] = field(default_factory=dict)


def usual_of(category: Category | None) -> Usual:
    """The usual width, depth and height of a category."""
    spread = category.describe_spread() if category else None
    if spread is None:
        return UNKNOWN
    mean, covariance = spread
    order = [1, 0, 2]
    return Usual(mean[order], covariance[np.ix_(order, order)])


def see_camera(rgb: NDArray[np.uint8], focal: float | None) -> CameraPrior:
    """What the lines of a picture (H, W, 3) tell of its camera; focal: pixels, if EXIF or a person tells it."""
    height, width = rgb.shape[:2]
    known = usual_focal(width, height, focal)
    proposed = propose(np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8), known)
    given = known.model_copy(update={"guides": proposed.guides})
    return CameraPrior(given, fit_view(given, width, height))


def make_item(
    value: int, label: str, ends: Mapping[int, Ends], on: Mapping[int, int], place: Mapping[int, int]
) -> Item:
    """A thing to be fitted; `place`: the numbers of the things in the fit."""
    category = category_of(label)
    legs = category is None or category.name in LEGGED
    across = category is not None and "seat" in category.kin
    return Item(
        ends[value], find_open(value, ends, on), usual_of(category), place.get(on[value], -1), legs=legs, across=across
    )


def scale_room(room: Room, labels: Mapping[int, str], heights: Mapping[str, float]) -> Room:
    """The room, as large as the heights say, metres, that a person knows of things by label, or of the `camera`."""
    factors = [heights["camera"] / room.view.above] if "camera" in heights else []
    factors += [heights[labels[value]] / box.size[2] for value, box in room.boxes.items() if labels[value] in heights]
    if not factors:
        return room
    factor = float(np.median(factors))
    walls = [WallPlane(wall.normal, factor * wall.offset) for wall in room.walls]
    boxes = {value: UprightBox(factor * box.center, factor * box.size, box.yaw) for value, box in room.boxes.items()}
    view, spread = replace(room.view, above=factor * room.view.above), room.spread._replace(height=0.0)
    return replace(room, view=view, spread=spread, walls=walls, boxes=boxes)


def build_room(
    rgb: NDArray[np.uint8],
    camera: CameraPrior,
    masks: NDArray[np.integer],
    labels: Mapping[int, str],
) -> Room:
    """The room that a picture (H, W, 3) shows.

    Args:
        masks: (H, W).
        labels: of the things, by the values of their masks; of none the camera is a usual one.
    """
    ends = measure_all(masks, list(labels), ~find_border(rgb))
    on = find_supports(masks, labels, ends)
    standing = [value for value in labels if on[value] not in (WALL, NOWHERE)]
    place = {value: number for number, value in enumerate(standing)}
    items = [make_item(value, labels[value], ends, on, place) for value in standing]
    view, boxes = replace(camera.view, above=float(np.exp(HEIGHT[0]))), dict[int, UprightBox]()
    spread, doubt = measure_spread_of_lines(camera), ""
    if items:
        layout, state, _ = fit_things(camera, items)
        spread, doubt = measure_spread(layout.measure_deviations, state), compare_tilts(layout, state)
        view, boxes = camera.view_of(state), dict(zip(standing, layout.list_boxes(state), strict=True))
    hung = [value for value in labels if on[value] == WALL]
    walls, hanging, holders = hang_things(rgb, view, masks, labels, boxes, hung)
    left_out = {value: "no wall that it hangs on is found" for value in hung if value not in hanging}
    left_out |= {value: "what it stands on is not seen" for value in labels if on[value] == NOWHERE}
    on = {value: holders.get(value, on[value]) for value in [*boxes, *hanging]}
    return Room(camera.given, view, spread, doubt, walls, boxes | hanging, on, left_out)


def hang_things(
    rgb: NDArray[np.uint8],
    view: View,
    masks: NDArray[np.integer],
    labels: Mapping[int, str],
    boxes: Mapping[int, UprightBox],
    hung: Sequence[int],
) -> tuple[list[WallPlane], dict[int, UprightBox], dict[int, int]]:
    """The walls of a room; boxes of what hangs on them, and on which: -1 - k for wall k."""
    unit = [WallPlane(normal, -1.0) for normal in NORMALS]
    facing, at_one = {}, {}
    for value in hung:
        found = [measure_rectangle(view, wall, masks == value) for wall in unit]
        facing[value] = int(np.argmax([share for share, _ in found]))
        at_one[value] = found[facing[value]][1]
    segments = list_free_segments(rgb, masks, list(labels))
    kinds = [category_of(labels[value]) for value in boxes]
    against = [one is not None and bool(AGAINST & set(one.kin)) for one in kinds]
    walls, hanging, holders = [], {}, {}
    for number, normal in enumerate(NORMALS):
        own = [value for value in hung if facing[value] == number and np.ptp(at_one[value][:, 0]) > 0]
        usual = [usual_of(category_of(labels[value])).mean for value in own]
        far = [float(np.exp(one[0]) / np.ptp(at_one[value][:, 0])) for value, one in zip(own, usual, strict=True)]
        wall = find_wall(view, normal, list(boxes.values()), against, segments, far)
        if wall is None:
            continue
        walls.append(wall)
        for value in own:
            _, ends = measure_rectangle(view, wall, masks == value)
            (along, above), (width, height) = ends.mean(axis=0), np.maximum(np.ptp(ends, axis=0), 0.01)
            size = float(width), usual_depth(labels[value]) or FLAT_DEPTH, float(height)
            hanging[value] = hang_box(wall, float(along), float(above), size)
            holders[value] = -len(walls)
    return walls, hanging, holders


def list_free_segments(rgb: NDArray[np.uint8], masks: NDArray[np.integer], values: list[int]) -> Array:
    """Lines (N, 2, 2) of a picture that no thing shows."""
    things = cv2.dilate(np.isin(masks, values).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    segments = find_segments(np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8))
    height, width = masks.shape
    samples = segments[:, :1] + np.linspace(0, 1, 9)[:, None] * (segments[:, 1:] - segments[:, :1])
    x, y = np.rint(samples).astype(int).transpose(2, 0, 1)
    covered = things[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)].mean(axis=1)
    return np.asarray(segments[covered < 0.3])
