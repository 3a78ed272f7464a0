"""The box of an outlined thing: what carries it by its foot, the rest by how far it reaches in the picture."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from plugins.annotator.fronts import front_corners
from plugins.annotator.project import Project
from plugins.annotator.solve import FLAT_DEPTH, Solved
from plugins.annotator.support import support_at
from plugins.inputs.photo.metrology import CLICK, MetrologyError, View, hang_box
from plugins.names.propose import Names, Proposal
from stages.contracts.categories import find_usual_size, known_categories, sizes_of
from stages.contracts.category import Category, find_category
from stages.contracts.types import Pixel
from stages.geometry.boxes import UprightBox, corners
from stages.geometry.masks import polygons

Array = NDArray[np.float64]
ANGLES = np.arange(16) * np.pi / 8
DIRECTIONS = np.stack([np.cos(ANGLES), np.sin(ANGLES)])  # (2, 16) in which outline and box reach equally far
DEEP = 0.6  # metres: how deep a thing is at most whose depth nothing tells, as `fit_standing_box`
SPREAD, LOOSE = 0.25, 0.5  # least spread of the logarithms of a category's sizes; that of a guessed depth; chosen
FAR = 2.0  # spreads from the usual beyond which a width or height is hardly drawn there; chosen
DEPTH_TOLD = 0.3  # logarithm of a change of depth that an outline tells if it moves it by a `CLICK`; chosen
SELDOM = 0.1  # how much seldomer things hang that stand, and the other way round; chosen
UNLIKELY = 0.3  # logarithms by which a size lies beyond the usual, for e times fewer chances; chosen
AT_BOUND = 0.05  # logarithm of a depth from its least, below which an outline shows none; chosen
LEAST, MOST = -5.0, 2.5  # logarithms of the least and the largest size in metres
BORDER = 2.0  # pixels to the picture's edge or to what is before it, within which an outline may go on; chosen
FACING = (-np.pi / 2, np.pi, 0.0)  # the sides of a box that may be its front: towards the camera first


class Fit(NamedTuple):
    """A box, how badly it fits, and whether the outline alone tells how deep it is."""

    box: UprightBox
    cost: float
    told: bool


@dataclass(frozen=True)
class Reach:
    """How far an outline reaches, pixels (16,), in `DIRECTIONS`, and where it may go on unseen (16,)."""

    far: Array
    open: NDArray[np.bool_]

    def misses(self, view: View, box: UprightBox) -> Array:
        """By how many times `CLICK` a box reaches too far (16,); where the outline may go on, it may."""
        pixels = np.nan_to_num(view.project(corners(box)), nan=10.0 * view.width)
        beyond = (pixels @ DIRECTIONS).max(axis=0) - self.far
        return np.where(self.open, np.minimum(beyond, 0), beyond) / CLICK


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
    view, usual = solved.view, usual_sizes(label)
    reach = measure_reach(project, hull, on)
    try:
        if on in solved.walls:
            fit = fit_hanging(solved, on, hull, reach, usual)
            return on, mark_box(view, fit, fit.box.yaw - np.pi / 2, hangs=True)
        ground = solved.boxes[on].top if on in solved.boxes else 0.0
        turned = usual[:, [1, 0, 2]] if len(usual) else usual
        fit = min((fit_standing(view, ground, hull, reach, one) for one in (usual, turned)), key=lambda fit: fit.cost)
        seen = [area_of(view.project(front_corners(fit.box, facing))) for facing in FACING]
        return on, mark_box(view, fit, FACING[int(np.argmax(seen))], hangs=False)
    except MetrologyError:  # no place: the page says why
        (x0, y0), (x1, y1) = hull.min(axis=0), hull.max(axis=0)
        return on, [(x0, y1), (x1, y0)] if on in solved.walls else [(x0, y1), (x1, y1), ((x0 + x1) / 2, y0)]


def weigh_names(names: Names, hangs: bool, width: float, height: float) -> Names:
    """Names of what hangs on a wall or stands, so wide and high, metres: what never does, or is, is hardly meant."""
    shares = []
    for one in names.proposals:
        category = known_categories()[one.name.replace(" ", "_")]
        usual = find_usual_size(category.name)
        misfit = usual.misfit([np.median(sizes_of(category.name)[:, 0]), width, height]) if usual else 0.0
        odd = is_standing(category) if hangs else category.places == ["wall"]
        shares.append(one.probability * float(np.exp(-misfit / UNLIKELY)) * (SELDOM if odd else 1))
    total = sum(shares) + names.other
    found = [Proposal(one.name, share / total) for one, share in zip(names.proposals, shares, strict=True)]
    return Names(sorted(found, key=lambda one: -one.probability), names.other / total)


def is_standing(category: Category | None) -> bool:
    """Whether nothing of a category's kind hangs: a cabinet, by that word alone, may."""
    hanging = {kind for one in known_categories().values() if "wall" in one.places for kind in one.kin}
    return category is not None and hanging.isdisjoint(category.kin)


def find_carrier(project: Project, solved: Solved, hull: Array, label: str) -> str:
    """What a hull (N, 2) stands or hangs on: what its foot is on, in the middle and to either side of it."""
    columns = np.quantile(np.clip([hull[:, 0].min(), hull[:, 0].max()], 0, project.width - 1), [0.25, 0.5, 0.75])
    mask = polygons([hull], (project.height, project.width))
    stands = is_standing(find_category(label, known_categories()))
    feet = [(column, row) for column in np.rint(columns).astype(int) for row in np.flatnonzero(mask[:, column])[-1:]]
    on = [support_at(project, solved, (float(x), float(y)), stands) for x, y in feet]
    if stands and set(on) == {"floor"}:  # or on something on that wall, which is not drawn yet
        on = [support_at(project, solved, (float(x), float(y))) for x, y in feet]
    name, count = Counter(on or ["floor"]).most_common(1)[0]
    return name if count == len(on) or "floor" not in on else "floor"


def usual_sizes(label: str) -> Array:
    """Logarithms (N, 3) of width, depth and height of what has a name; none: unknown."""
    sizes = sizes_of(label)
    return np.log(sizes[:, [1, 0, 2]]) if len(sizes) else np.zeros((0, 3))


def measure_reach(project: Project, hull: Array, on: str) -> Reach:
    """How far a hull (N, 2) reaches, and where the picture's edge, or the outline of a thing before it, may cut it."""
    far = hull @ DIRECTIONS
    ends = hull[far.argmax(axis=0)]  # (16, 2)
    limit = np.array([project.width, project.height]) - 1
    cut = ((ends < BORDER) | (ends > limit - BORDER)).any(axis=1)
    for item in project.objects:
        rings = item.outlines if item.id != on else []
        if max((point[1] for ring in rings for point in ring), default=0) > hull[:, 1].max():  # its foot is nearer
            for ring in rings:
                edge = np.array(ring, np.float32)
                inside = [cv2.pointPolygonTest(edge, (float(x), float(y)), True) > -2 * CLICK for x, y in ends]
                cut |= np.array(inside) & (DIRECTIONS[1] > 0.5)
    return Reach(far.max(axis=0), cut)


def fit_standing(view: View, ground: float, hull: Array, reach: Reach, usual: Array) -> Fit:
    """The box on a level, along the room, that reaches as far as the outline and is about as large as usual.

    Raises:
        MetrologyError: its foot lies above the horizon.
    """
    low, high = hull[hull[:, 1].argmax()], hull[hull[:, 1].argmin()]
    foot = view.meet_level(low, ground)
    left, right = (view.meet_plane((x, low[1]), [0, 1, 0], foot[1]) for x in (hull[:, 0].min(), hull[:, 0].max()))
    height = view.meet_plane((low[0], high[1]), [0, 1, 0], foot[1])[2] - ground
    width = max(float(right[0] - left[0]), 0.01)
    start = np.array([(left[0] + right[0]) / 2, foot[1], *np.log([width, min(width, DEEP), max(height, 0.01)])])

    def box_of(values: Array) -> UprightBox:
        size = np.exp(values[2:])
        return UprightBox([values[0], values[1] + size[1] / 2, ground + size[2] / 2], size, 0.0)

    return fit_box(view, box_of, start, reach, usual)


def fit_hanging(solved: Solved, on: str, hull: Array, reach: Reach, usual: Array) -> Fit:
    """The box with its rear on a wall that reaches as far as the outline and is about as deep as usual."""
    view, wall = solved.view, solved.walls[on]
    points = np.array([view.meet_plane(pixel, wall.normal, wall.offset) for pixel in hull])
    along, up = points @ wall.along, points[:, 2]
    middle = [(along.min() + along.max()) / 2, (up.min() + up.max()) / 2]
    start = np.array([*middle, *np.log([max(np.ptp(along), 0.01), FLAT_DEPTH, max(np.ptp(up), 0.01)])])

    def box_of(values: Array) -> UprightBox:
        width, depth, height = np.exp(values[2:]).tolist()
        return hang_box(wall, values[0], values[1], (width, depth, height))

    return fit_box(view, box_of, start, reach, usual)


def fit_box(view: View, box_of: Callable[[Array], UprightBox], start: Array, reach: Reach, usual: Array) -> Fit:
    """The box by two coordinates and the logarithms of its sizes: where none are usual, as deep as it begins.

    A width or height that is far from the usual is not drawn there: a row of cabinets is called a cabinet. An outline
    that shows no depth is that of its front alone: the doors of a counter without its worktop.
    """
    mean, spread = np.array([0, start[3], 0]), np.array([np.inf, LOOSE, np.inf])
    if len(usual):
        mean, spread = usual.mean(axis=0), np.maximum(usual.std(axis=0), SPREAD)
        start[3] = mean[1]
    low, high = np.array([-np.inf, -np.inf, *[LEAST] * 3]), np.array([np.inf, np.inf, *[MOST] * 3])
    low[3], high[3] = mean[1] - FAR * spread[1], mean[1] + FAR * spread[1]

    def misses(values: Array) -> Array:
        return np.concatenate([reach.misses(view, box_of(values)), FAR * np.tanh((values[2:] - mean) / spread / FAR)])

    found = least_squares(misses, np.clip(start, low, high), bounds=(low, high), loss="soft_l1", max_nfev=200)
    if found.x[3] < low[3] + AT_BOUND:
        low[3], high[3] = LEAST, LEAST + AT_BOUND
        found = least_squares(misses, np.clip(found.x, low, high), bounds=(low, high), loss="soft_l1", max_nfev=200)
        return Fit(box_of(found.x), float(found.cost), False)
    step = np.array([0, 0, 0, DEPTH_TOLD, 0])
    sides = [reach.misses(view, box_of(found.x + sign * step)) for sign in (-1, 1)]
    told = min(float(np.linalg.norm(side - reach.misses(view, box_of(found.x)))) for side in sides) > 1
    return Fit(box_of(found.x), float(found.cost), told)


def mark_box(view: View, fit: Fit, facing: float, hangs: bool) -> list[Pixel]:
    """The marks that make a box: of its front, and of a rear corner if the outline tells how deep it is.

    Raises:
        MetrologyError: it reaches behind the camera.
    """
    pixels, behind = (view.project(front_corners(fit.box, way)) for way in (facing, facing + np.pi))
    if not np.isfinite([*pixels, *behind]).all():
        raise MetrologyError("it reaches behind the camera")
    marks = [pixels[0], pixels[2]] if hangs else [pixels[0], pixels[1], (pixels[2] + pixels[3]) / 2]
    beside = [-cv2.pointPolygonTest(pixels.astype(np.float32), (float(x), float(y)), True) for x, y in behind]
    if fit.told and max(beside) > 2 * CLICK:
        marks.append(behind[int(np.argmax(beside))])
    return [(round(float(x), 1), round(float(y), 1)) for x, y in marks]


def area_of(pixels: Array) -> float:
    """Pixels that a side (4, 2) covers; 0: it looks away from the camera."""
    (ax, ay), (bx, by) = pixels[2] - pixels[0], pixels[3] - pixels[1]
    area = ay * bx - ax * by
    return float(area) if np.isfinite(area) and area > 0 else 0.0
