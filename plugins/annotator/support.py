"""What a pixel of a drawing shows that something may stand or hang on."""

import cv2
import numpy as np

from plugins.annotator.project import Project
from plugins.annotator.solve import Solved
from plugins.inputs.photo.metrology import CLICK
from stages.geometry.boxes import corners

BASE_SLACK = 0.05  # share of the picture's height: a base may be marked so far above the top that it stands on
WORKTOP = 0.05  # metres: how thick a worktop is, whose lower edge is easily marked in place of its upper one


def support_at(project: Project, solved: Solved, pixel: tuple[float, float], stands: bool = False) -> str:
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
