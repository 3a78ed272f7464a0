"""The box of an outlined thing: what carries it by its foot, the rest by the fit of pictures without depth."""

from collections import Counter

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.categories import find_usual_size, known_categories, sizes_of, usual_depth
from roomkin.stages.contracts.category import CategoryFacts, find_category
from roomkin.stages.contracts.types import Pixel
from roomkin.stages.geometry.boxes import UprightBox, corners, front_corners
from roomkin.stages.geometry.frames import yaw_matrix
from roomkin.stages.geometry.masks import Mask, polygons
from roomkin.stages.perception.camera.metrology import CLICK, FLAT_DEPTH, MetrologyError, PinholeView, hang_box
from roomkin.stages.perception.classification.names import Names
from roomkin.stages.perception.drawing.project import Project
from roomkin.stages.perception.drawing.room import TURNS, area_of, mark_box
from roomkin.stages.perception.drawing.solve import Solved
from roomkin.stages.perception.layout.ends import FLOOR as ON_FLOOR
from roomkin.stages.perception.layout.ends import find_open, kind_of, measure_all, number_masks
from roomkin.stages.perception.layout.fit import CameraPrior, FitItem, place_things
from roomkin.stages.perception.layout.walls import measure_rectangle

Array = NDArray[np.float64]
DEPTH_TOLD = 0.3  # logarithm of a change of depth that an outline tells if it moves it by a `CLICK`; chosen
SELDOM = 0.1  # how much seldomer things hang that stand, and the other way round; chosen
UNLIKELY = 0.3  # logarithms by which a size lies beyond the usual, for e times fewer chances; chosen
BASE_SLACK = 0.05  # share of the picture's height: a base may be marked so far above the top that it stands on
WORKTOP = 0.05  # metres: how thick a worktop is, whose lower edge is easily marked in place of its upper one


def propose_box(
    project: Project, solved: Solved, outlines: list[list[Pixel]], on: str, label: str
) -> tuple[str, list[Pixel]]:
    """What carries an outlined thing, and the marks of its box, as a person would click them (`DrawnObject.points`).

    Args:
        on: the floor, a wall or an object; auto: what its foot is on.
        label: whose usual sizes tell what the outline does not; empty: unknown.
    """
    hull = cv2.convexHull(np.concatenate([np.asarray(points, np.float32) for points in outlines]))[:, 0].astype(float)
    if on == "auto":
        on = find_carrier(project, solved, hull, label)
    shape, view = (project.height, project.width), solved.view
    try:
        if on in solved.walls:
            box, told = hang_outline(solved, on, polygons(outlines, shape), label), False
        else:
            ground = solved.boxes[on].top if on in solved.boxes else 0.0
            view.meet_level(hull[hull[:, 1].argmax()], ground)
            box, told = fit_standing(project, view, polygons(outlines, shape), on, ground, label)
        return on, mark_box(view, box, on in solved.walls, told)
    except (MetrologyError, ValueError):  # no place: the page says why
        (x0, y0), (x1, y1) = hull.min(axis=0), hull.max(axis=0)
        return on, [(x0, y1), (x1, y0)] if on in solved.walls else [(x0, y1), (x1, y1), ((x0 + x1) / 2, y0)]


def weigh_names(names: Names, hangs: bool, width: float, height: float) -> Names:
    """Names of what hangs on a wall or stands, so wide and high, metres: what never does, or is, is hardly meant."""
    weights = {}
    for name, category in known_categories().items():
        usual = find_usual_size(name)
        misfit = usual.misfit([np.median(sizes_of(name)[:, 0]), width, height]) if usual else 0.0
        odd = is_standing(category) if hangs else category.places == ["wall"]
        weights[name] = float(np.exp(-misfit / UNLIKELY)) * (SELDOM if odd else 1)
    return names.weigh(weights)


def is_standing(category: CategoryFacts | None) -> bool:
    """Whether nothing of a category's kind hangs: a cabinet, by that word alone, may."""
    hanging = {kind for one in known_categories().values() if "wall" in one.places for kind in one.kin}
    return category is not None and hanging.isdisjoint(category.kin)


def find_carrier(project: Project, solved: Solved, hull: Array, label: str) -> str:
    """What a hull (N, 2) stands or hangs on: what its foot is on, in the middle and to either side of it."""
    columns = np.quantile(np.clip([hull[:, 0].min(), hull[:, 0].max()], 0, project.width - 1), [0.25, 0.5, 0.75])
    mask = polygons([hull], (project.height, project.width))
    stands = is_standing(find_category(label, known_categories()))
    feet = [(column, row) for column in np.rint(columns).astype(int) for row in np.flatnonzero(mask[:, column])[-1:]]
    on = [support_at(solved, (float(x), float(y)), stands) for x, y in feet]
    if stands and set(on) == {"floor"}:  # or on something on that wall, which is not drawn yet
        on = [support_at(solved, (float(x), float(y))) for x, y in feet]
    name, count = Counter(on or ["floor"]).most_common(1)[0]
    return name if count == len(on) or "floor" not in on else "floor"


def hang_outline(solved: Solved, on: str, mask: Mask, label: str) -> UprightBox:
    """The box on a wall that is as wide and high as a mask (H, W) there, and as deep as usual."""
    share, ends = measure_rectangle(solved.view, solved.walls[on], mask)
    if not share:
        raise MetrologyError("it does not face the camera there")
    (along, above), (width, height) = ends.mean(axis=0), np.maximum(np.ptp(ends, axis=0), 0.01)
    size = float(width), usual_depth(label) or FLAT_DEPTH, float(height)
    return hang_box(solved.walls[on], float(along), float(above), size)


def fit_standing(
    project: Project, view: PinholeView, mask: Mask, on: str, ground: float, label: str
) -> tuple[UprightBox, bool]:
    """The box on a level, along the room, that ends where a mask (H, W) does and is about as large as usual; whether
    that tells how deep it is."""
    drawn = [polygons(item.outlines, mask.shape) for item in project.objects if item.outlines and item.id != on]
    values, own = number_masks(dict(enumerate([*drawn, mask], 1)), mask.shape), len(drawn) + 1
    ends = measure_all(values, [value for value in range(1, own + 1) if (values == value).any()], np.ones_like(mask))
    hidden, kind = find_open(own, ends, dict.fromkeys(ends, ON_FLOOR)), kind_of(label)
    item = FitItem(ends[own], hidden, kind.usual, legs=kind.legs and bool(label), ground=ground)
    camera = CameraPrior(project.perspective, view)
    fitted = place_things(camera, [item], np.array([*camera.state, np.log(view.above)]))
    (box,) = fitted.layout.list_boxes(fitted.state)
    return box, tells_depth(view, box, item.open)


def tells_depth(view: PinholeView, box: UprightBox, hidden: Mask) -> bool:
    """Whether an outline would show it, if a box went back farther, or less far; `hidden` (4,): ends that it lacks."""
    fronts = [box.yaw + turn for turn in TURNS[:-1]]
    front = max(fronts, key=lambda way: area_of(view.project(front_corners(box, way))))
    inward = -yaw_matrix(front)[:, 0]
    deep = int(np.argmax(np.abs(yaw_matrix(box.yaw).T @ inward)[:2]))

    def find_ends(depth: float) -> Array:
        size = box.size.copy()
        size[deep] = depth
        pixels = view.project(corners(UprightBox(box.center + inward * (depth - box.size[deep]) / 2, size, box.yaw)))
        return np.where(hidden, 0.0, np.concatenate([-pixels.min(axis=0), pixels.max(axis=0)]))

    now, *others = (find_ends(float(box.size[deep] * np.exp(by))) for by in (0, -DEPTH_TOLD, DEPTH_TOLD))
    return min(float(np.linalg.norm(ends - now)) for ends in others) > CLICK


def support_at(solved: Solved, pixel: tuple[float, float], stands: bool = False) -> str:
    """What a pixel shows that something may stand or hang on: the top of an object, a wall, else the floor.

    An object that `stands` hangs on no wall, though on a counter that was drawn too shallow its base seems to be on
    the wall behind.

    Marks are a few pixels off: the base of an object at the front edge of a top is easily marked below the edge, at
    the rear edge up the wall; and the top itself may be marked at the lower edge of the worktop. A top of guessed depth
    may reach farther back than it is drawn.
    """
    ray, eye = solved.view.rays(pixel), np.array([0, 0, solved.view.above])
    best, nearest = "floor", np.inf
    beside: dict[str, float] = {}  # pixels from the tops that the pixel is not on
    for name, box in solved.boxes.items():
        top = solved.view.project(corners(box)[4:])
        if ray[2] >= 0 or box.top >= eye[2] or not np.isfinite(top).all():
            continue
        reach = (box.top - eye[2]) / ray[2]
        inside = cv2.pointPolygonTest(top.astype(np.float32), pixel, True)
        if inside <= -2 * CLICK:
            beside[name] = -inside
        elif reach < nearest:
            best, nearest = name, reach
    if best != "floor":
        return best
    if ray[2] < 0:
        nearest = -eye[2] / ray[2]
    for name, wall in solved.walls.items():
        if (reach := float(wall.reach(ray))) < nearest:
            best, nearest = name, reach
    close = min(beside, key=lambda name: beside[name], default="floor")
    near = beside.get(close, np.inf) < BASE_SLACK * solved.view.height
    if near and close in solved.guessed and _is_behind(solved, close, pixel, nearest):
        return close
    if best == "floor":
        return best
    if stands:
        return close if near else "floor"
    if close == "floor":
        return best
    away = float(np.linalg.norm(solved.boxes[close].center - eye)) * (solved.factor or 1.0)
    return close if beside[close] < solved.view.focal * WORKTOP / away + 2 * CLICK else best


def _is_behind(solved: Solved, name: str, pixel: tuple[float, float], reach: float) -> bool:
    """Whether a pixel that shows what is `reach` away lies behind a box: its top, if deeper, would reach there."""
    box, eye = solved.boxes[name], np.array([0, 0, solved.view.above])
    columns = solved.view.project(corners(box)[4:])[:, 0]
    across = columns.min() - 2 * CLICK < pixel[0] < columns.max() + 2 * CLICK
    return bool(across and reach > (box.center - eye) @ solved.view.rotation[:, 2])
