"""What the pages show of a solved room: fronts seen straight on, boxes and planes as pixels and numbers."""

import base64
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.boxes import FACES, UprightBox, corners
from roomkin.stages.perception.camera.metrology import PinholeView, UprightPlane
from roomkin.stages.perception.camera.perspective import find_weak_lines, horizon, vanishing_point
from roomkin.stages.perception.drawing.project import Project
from roomkin.stages.perception.drawing.room import area_of
from roomkin.stages.perception.drawing.solve import Solved

LONGEST = 400  # pixels of its longer side
GRID, REACH = 0.5, 8.0  # metres: spacing of the floor's grid, and how far it goes
Answer = dict[str, Any]


def rectify_front(rgb: NDArray[np.uint8], pixels: NDArray[np.float64], width: float, height: float) -> dict[str, Any]:
    """A front as the page shows it: a picture of `width` x `height` pixels; null where it looks away from the camera.

    Args:
        rgb: the whole picture.
        pixels: the front's corners (4, 2), in the order of `front_corners`; NaN: behind the camera.
        width: of the front, in any unit.
        height: likewise.
    """
    longest = max(width, height)
    size = [max(1, round(LONGEST * side / longest)) for side in (width, height)]
    answer: dict[str, Any] = {"width": size[0], "height": size[1], "picture": None}
    if area_of(pixels) <= 1.0:
        return answer
    right, low = size[0] - 0.5, size[1] - 0.5
    target = np.array([(-0.5, low), (right, low), (right, -0.5), (-0.5, -0.5)], np.float32)
    turn = cv2.getPerspectiveTransform(pixels.astype(np.float32), target)
    front = np.asarray(cv2.warpPerspective(rgb, turn, size), np.uint8)
    return answer | {"picture": "data:image/jpeg;base64," + base64.b64encode(jpeg(front)).decode("ascii")}


def jpeg(rgb: NDArray[np.uint8]) -> bytes:
    """A picture (H, W, 3) as the bytes of a JPEG."""
    done, data = cv2.imencode(".jpg", rgb[..., ::-1])
    assert done
    return data.tobytes()


def _lines(view: PinholeView, ends: NDArray[np.float64]) -> list[list[list[float]]]:
    """Pixels of lines (N, 2, 3) of the room, as far as they are before the camera."""
    lines = []
    eye, forward = np.array([0, 0, view.above]), view.rotation[:, 2]
    near = 0.05 * view.above
    for a, b in ends:
        da, db = (a - eye) @ forward, (b - eye) @ forward
        if max(da, db) <= near:
            continue
        if min(da, db) < near:
            cut = a + (b - a) * (near - da) / (db - da)
            a, b = (cut, b) if da < db else (a, cut)
        lines.append(np.round(view.project([a, b]), 1).tolist())
    return lines


def _box(view: PinholeView, box: UprightBox) -> Answer:
    """A box in pixels: its corners (null behind the camera), which faces are seen, and its size and distance."""
    points = corners(box)
    pixels = view.project(points)
    eye = np.array([0, 0, view.above])
    faces = []
    for face in FACES:
        middle = points[list(face)].mean(axis=0)
        if (middle - box.center) @ (eye - middle) > 0 and np.isfinite(pixels[list(face)]).all():
            faces.append(np.round(pixels[list(face)], 1).tolist())
    foot = view.project(points[[3, 2]] * [1, 1, 0])  # where a wall behind it meets the floor
    known = [bool(np.isfinite(pixel).all()) for pixel in pixels]
    return {
        "corners": [np.round(pixel, 1).tolist() if ok else None for pixel, ok in zip(pixels, known, strict=True)],
        "faces": faces,
        "foot": np.round(foot, 1).tolist() if np.isfinite(foot).all() else None,
        "size": [round(float(value), 4) for value in box.size],
        "distance": round(float(np.linalg.norm(box.center - eye)), 3),
    }


def _wall(view: PinholeView, wall: UprightPlane) -> list[list[list[float]]]:
    """A wall's foot from end to end, as lines of pixels."""
    foot = wall.offset * wall.normal
    reach = 4 * REACH * max(view.above, 0.1)
    low, high = np.clip(wall.ends, -reach, reach)
    return _lines(view, np.array([[foot + low * wall.along, foot + high * wall.along]]))


def _grid(view: PinholeView) -> list[list[list[float]]]:
    """Lines on the floor every half metre."""
    steps = np.arange(-REACH, REACH + GRID / 2, GRID)
    lines = [((x, 0, 0), (x, REACH, 0)) for x in steps] + [((-REACH, y, 0), (REACH, y, 0)) for y in steps[steps >= 0]]
    return _lines(view, np.array(lines, dtype=float))


def describe_room(project: Project, solved: Solved) -> Answer:
    """The solved room for the page."""
    view = solved.view
    up, forward = view.rotation[2], view.rotation[:, 2]
    return {
        "camera": {
            "focal": round(view.focal, 1),
            "across": round(float(np.rad2deg(2 * np.arctan(view.width / 2 / view.focal))), 1),
            "pitch": round(float(np.rad2deg(np.arcsin(np.clip(forward[2], -1, 1)))), 2),
            "roll": round(float(np.rad2deg(np.arctan2(up[0], -up[1]))), 2),
            "above": round(view.above, 3),
            "factor": solved.factor,
        },
        "horizon": horizon(view),
        "vanishing": {name: vanishing_point(view, axis) for axis, name in enumerate("xyz")},
        "weak": find_weak_lines(view, project.perspective.guides),
        "grid": _grid(view),
        "walls": {name: _wall(view, wall) for name, wall in solved.walls.items()},
        "boxes": {name: _box(view, box) for name, box in solved.boxes.items()},
        "notes": solved.notes,
        "usual": solved.usual,
    }
