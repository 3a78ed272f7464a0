"""Yaw of a model from the matched view, the cloud and the walls; boxes end at walls they touch (paper A.7, A.3)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from shapely import MultiPoint

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts.category import CategoryFacts
from roomkin.stages.contracts.cousins import Cousin, Orientation
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.geometry.boxes import THINNEST, UprightBox, corners, depth_behind, volume
from roomkin.stages.geometry.frames import SYMMETRY_PERIOD, view_yaw, wrap_angle, yaw_matrix
from roomkin.stages.geometry.robust import SPREAD

ALONG_SIDE = np.deg2rad(15)  # what is turned less than this against a side runs along it; chosen
QUARTER = SYMMETRY_PERIOD["quarter_turn"]
AS_WELL = 0.12  # of a judge's score, by which a front may fit worse than a rear and still be what is seen; on `work`
BACK_TO_WALL = {"storage", "appliance", "fixture"}  # kinds of things whose rear is never seen


def find_yaw(
    cousin: Cousin,
    box: UprightBox,
    cloud: NDArray[np.floating],
    camera: ArrayLike,
    touched: Sequence[Wall],
    articulated: bool,
    options: GenerationConfig,
    category: CategoryFacts | None = None,
) -> float:
    """The matched yaw, turned to the wall that the object touches (A.3), else to the axes of its cloud (A.7).

    Args:
        box, cloud: of the object, floor frame, which touches the walls `touched`, the dominant one first.
        articulated: whether the model is; `category`: its.
    """
    views = [cousin.orientation, *cousin.orientations]
    if options.wall_view == "rear":
        views = prefer_front(views, category)
    yaws = [view_yaw(camera, box.center, view.yaw) for view in views]
    yaw = pick_rear_at_wall(yaws, [wall.normal for wall in touched]) if options.wall_view == "rear" else yaws[0]
    if touched:
        return turn_to(yaw, find_wall_axes(touched[0].normal))
    if measure_rectangularity(cloud, box.yaw) < options.rectangularity:
        return yaw
    limit = options.snap_articulated if articulated else options.snap_other
    return turn_to(yaw, box.yaw, None if limit is None else float(np.deg2rad(limit)))


def prefer_front(views: Sequence[Orientation], category: CategoryFacts | None) -> list[Orientation]:
    """The views, best first; where the best shows a rear, and the opposite one fits as well, that one before it.

    Seen from above and in part, fronts and rears of cupboards, televisions and sofas have one outline and one depth.
    What hangs on walls, or stands with its back to one, shows its front however much worse that fits.
    """
    first, *others = views
    turned = category is not None and ("wall" in category.places or bool(BACK_TO_WALL & set(category.kin)))
    for view in others if abs(wrap_angle(first.yaw)) > np.pi / 2 else ():
        opposite = abs(wrap_angle(view.yaw - first.yaw - np.pi)) < QUARTER / 2 and abs(wrap_angle(view.yaw)) < np.pi / 2
        judged = first.score is not None and view.score is not None and view.score > first.score - AS_WELL
        if opposite and (turned or judged):
            return [view, *views]
    return list(views)


def pick_rear_at_wall(yaws: Sequence[float], normals: Sequence[ArrayLike]) -> float:
    """The first of the yaws, best first, at which the model's rear (-x) is to one of the walls; the first if none is.

    A.3 lays the rear face into the wall. A patch encoder often takes the rear or a side of furniture for its
    front, and one of the next best views is right.

    Args:
        normals: horizontal normals of the walls that the object touches, into the room.
    """
    for yaw in yaws:
        if any(abs(wrap_angle(yaw - find_wall_axes(normal))) <= QUARTER / 2 for normal in normals):
            return yaw
    return yaws[0]


def find_wall_axes(normal: ArrayLike) -> float:
    """Angle of the frame whose x axis is the normal of a wall."""
    x, y = np.asarray(normal, dtype=float)[:2]
    return float(np.arctan2(y, x))


def turn_to(yaw: float, axes: float, limit: float | None = None) -> float:
    """`yaw` turned by the smallest angle that lays the model's x or y axis along the frame at angle `axes`.

    Args:
        limit: largest turn in radians; a larger one is not made. None: no limit.
    """
    turn = wrap_angle(axes - yaw, QUARTER)
    return yaw if limit is not None and abs(turn) > limit else wrap_angle(yaw + turn)


def measure_rectangularity(cloud: NDArray[np.floating], yaw: float) -> float:
    """Share, in [0, 1], of the cloud's outline from above that runs along the axes turned by `yaw`.

    1 for a rectangle seen whole, 0.6 for its front and one side, about a quarter for a round thing.
    """
    outline = MultiPoint(np.asarray(cloud, dtype=float)[:, :2]).convex_hull.simplify(SPREAD)
    points = np.asarray(outline.exterior.coords if outline.geom_type == "Polygon" else outline.coords)
    sides = np.diff(points, axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    if not lengths.sum():
        return 0.0
    turns = np.abs([wrap_angle(angle - yaw, QUARTER) for angle in np.arctan2(sides[:, 1], sides[:, 0])])
    return float(lengths[turns <= ALONG_SIDE].sum() / lengths.sum())


PLACE_TOLERANCE = 0.05  # metres by which a place may be missed: of the floor, of a wall; chosen


def fit_stated_box(box: UprightBox, yaw: float, walls: Sequence[Wall]) -> UprightBox:
    """A box that the input tells, with the axes of a model at `yaw`, which run along its own; it ends at the walls."""
    size = box.size.copy()
    if round((yaw - box.yaw) / (np.pi / 2)) % 2:
        size[:2] = size[1::-1]
    box = UprightBox(box.center, np.maximum(size, THINNEST), yaw)
    for wall in walls:
        box = min(box, extend_to_wall(box, wall), key=volume)
    return box


def extend_to_wall(box: UprightBox, wall: Wall) -> UprightBox:
    """The box rescaled along its own axis so that its rear reaches the wall and its front stays where it is.

    If the box is turned a little against the wall (the second wall of a corner), its edge touches the wall.
    """
    normal = np.asarray(wall.normal, dtype=float)
    along = normal @ yaw_matrix(box.yaw)
    axis = int(np.argmax(np.abs(along[:2])))
    if abs(along[axis]) < np.cos(ALONG_SIDE):
        return box
    size = box.size.copy()
    edges = size[1 - axis] * abs(along[1 - axis])  # how much farther than its middle the turned faces reach, both
    front = float((corners(box) @ normal).max())
    size[axis] = max((front - wall.offset - edges) / abs(along[axis]), THINNEST)
    middle = wall.offset + (size[axis] * abs(along[axis]) + edges) / 2
    shift = yaw_matrix(box.yaw)[:, axis] * (middle - box.center @ normal) / along[axis]
    return UprightBox(box.center + shift, size, box.yaw)


def move_to_wall(box: UprightBox, wall: Wall) -> UprightBox:
    """The box moved so that it ends at a wall, if it nearly does."""
    depth = depth_behind(box, wall.normal, wall.offset)
    return replace(box, center=box.center + depth * np.asarray(wall.normal)) if abs(depth) < PLACE_TOLERANCE else box


def move_out_of_walls(box: UprightBox, walls: list[Wall]) -> UprightBox:
    """The box moved out of the walls that it reaches into, if its center is in front of them."""
    for wall in walls:
        normal, depth = np.asarray(wall.normal, dtype=float), depth_behind(box, wall.normal, wall.offset)
        if depth > 0 and box.center @ normal > wall.offset:
            box = replace(box, center=box.center + depth * normal)
    return box
