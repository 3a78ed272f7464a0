"""A room as a drawing, as a person would have drawn it on the page: camera, walls and boxes with their outlines."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.parts import says_opening
from roomkin.stages.contracts.types import LARGEST, Pixel
from roomkin.stages.geometry.boxes import UprightBox, front_corners
from roomkin.stages.geometry.masks import outline_pieces
from roomkin.stages.perception.camera.metrology import CLICK, MetrologyError, PinholeView, UprightPlane
from roomkin.stages.perception.camera.perspective import fit_view, horizon
from roomkin.stages.perception.classification.names import Names
from roomkin.stages.perception.drawing.project import DrawnObject, DrawnWall, Guess, Project, Scale, describe_odd
from roomkin.stages.perception.drawing.solve import UNSURE, Solved
from roomkin.stages.perception.layout.room import FittedRoom
from roomkin.stages.perception.layout.walls import end_walls
from roomkin.stages.perception.write import tell_names

Array = NDArray[np.float64]
REACH = 8.0  # metres of a wall to either side that are drawn
TURNS = (-np.pi / 2, np.pi, 0.0, np.pi / 2)  # to the sides of a box: that towards the camera first, its rear last
OPPOSITE = (3, 2, 1, 0)
ALONG = 1e-6  # sine of what is no angle
AHEAD = 0.3  # metres before the camera, nearer than which nothing is drawn


class Drawing(NamedTuple):
    """A drawing, the same solved, and why the rest of the things are left out, by the values of their masks."""

    project: Project
    solved: Solved
    left_out: dict[int, str]


def draw_room(name: str, room: FittedRoom, masks: NDArray[np.integer], labels: Mapping[int, str]) -> Drawing:
    """The drawing of a room, whose boxes are known: the marks are for the page.

    Args:
        name: file name of the picture.
        masks: (H, W).
        labels: of the things, by the values of their masks.
    """
    height, width = masks.shape
    fixed, above = {"horizon": horizon(room.view), "focal": room.view.focal}, round(room.view.above, 3)
    perspective = room.perspective.model_copy(update=fixed)
    view = replace(fit_view(perspective, width, height), above=above)
    left_out, objects = dict(room.left_out), list[DrawnObject]()
    walls = {f"wall_{number}": wall for number, wall in enumerate(room.walls, 1)}
    drawn = {name: found for name, wall in walls.items() if (found := draw_wall(view, name, wall)) is not None}
    for value, box in room.boxes.items():
        on = room.on[value]
        try:
            points = mark_box(view, box, on < 0)
            if max(box.size) > LARGEST:
                raise MetrologyError(f"would be {max(box.size):.0f} m large")
        except MetrologyError as error:
            left_out[value] = str(error)
            continue
        rings = outline_pieces(masks == value)
        objects.append(
            DrawnObject(
                id=f"thing_{value}",
                label=labels[value],
                on="floor" if on == 0 else f"wall_{-on}" if on < 0 else f"thing_{on}",
                points=points,
                free=bool(abs(np.sin(2 * box.yaw)) >= ALONG),
                depth=None if len(points) > (2 if on < 0 else 3) else round(float(box.size[1]), 3),
                articulated=says_opening(labels[value]),
                outline=rings[0] if rings else [],
                pieces=rings[1:],
                unsure=True,
            )
        )
    kept = keep_carried(objects, list(drawn))
    left_out |= {int(item.id[6:]): "what carries it has no place" for item in objects if item not in kept}
    project = Project(
        picture=name,
        width=width,
        height=height,
        perspective=perspective,
        scale=Scale(kind="camera", metres=above),
        walls=list(drawn.values()),
        objects=kept,
        untouched=True,
    )
    planes = end_walls(view, walls, {name: (line.a, line.b) for name, line in drawn.items()})
    boxes = {item.id: room.boxes[int(item.id[6:])] for item in kept}
    odd = {item.id: describe_odd(item, boxes[item.id], 1.0) for item in kept}
    notes = {name: "; ".join(filter(None, [UNSURE, what])) for name, what in odd.items()}
    return Drawing(project, Solved(view, planes, boxes, notes), left_out)


def add_found(
    project: Project, masks: NDArray[np.integer], named: Mapping[int, Names], left_out: Mapping[int, str]
) -> Project:
    """The drawing of a room with the names that its things may have, and with what is left out, the surest first.

    Args:
        masks: (H, W).
        named: things by the values of their masks.
        left_out: why some of them are.
    """
    told = {value: tell_names(names) for value, names in named.items()}
    guesses = []
    for value in sorted(left_out, key=lambda value: -told[value].probability):
        rings, opens = outline_pieces(masks == value), says_opening(told[value].names[0].name)
        shown = {"outline": rings[0] if rings else [], "pieces": rings[1:], **dict(told[value])}
        guesses.append(Guess(id=f"thing_{value}", articulated=opens, left_out=left_out[value], **shown))
    objects = [item.model_copy(update=dict(told[int(item.id[6:])])) for item in project.objects]
    return project.model_copy(update={"objects": objects, "left_out": guesses})


def keep_carried(objects: list[DrawnObject], walls: list[str]) -> list[DrawnObject]:
    """The objects that the floor, a wall, or another of them carries."""
    there = {"floor", *walls, *(item.id for item in objects)}
    kept = [item for item in objects if item.on in there]
    return kept if len(kept) == len(objects) else keep_carried(kept, walls)


def draw_wall(view: PinholeView, name: str, wall: UprightPlane) -> DrawnWall | None:
    """A wall by two points of its foot; None: none lies before the camera."""
    feet = wall.offset * wall.normal + np.linspace(-REACH, REACH, 81)[:, None] * wall.along
    before = (feet - [0, 0, view.above]) @ view.rotation[:, 2] > AHEAD
    if before.sum() < 2:
        return None
    ends = view.project(feet[before][[0, -1]])
    a, b = ((round(float(x), 1), round(float(y), 1)) for x, y in ends)
    return DrawnWall(id=name, a=a, b=b)


def area_of(pixels: Array) -> float:
    """Pixels that a side (4, 2) covers; 0: it looks away from the camera."""
    (ax, ay), (bx, by) = pixels[2] - pixels[0], pixels[3] - pixels[1]
    area = ay * bx - ax * by
    return float(area) if np.isfinite(area) and area > 0 else 0.0


def mark_box(view: PinholeView, box: UprightBox, hangs: bool, told: bool = True) -> list[Pixel]:
    """The marks that make a box, as a person would click them: of its front, and of a rear corner.

    Args:
        hangs: on a wall, by its rear.
        told: how deep it is; else a rear corner says nothing.

    Raises:
        MetrologyError: it reaches behind the camera.
    """
    sides = [view.project(front_corners(box, box.yaw + turn)) for turn in TURNS]
    best = 0 if hangs else int(np.argmax([area_of(pixels) for pixels in sides[:-1]]))
    pixels, behind = sides[best], sides[OPPOSITE[best]]
    if not np.isfinite([*pixels, *behind]).all():
        raise MetrologyError("it reaches behind the camera")
    marks = [pixels[0], pixels[2]] if hangs else [pixels[0], pixels[1], (pixels[2] + pixels[3]) / 2]
    beside = [-cv2.pointPolygonTest(pixels.astype(np.float32), (float(x), float(y)), True) for x, y in behind]
    if told and not hangs and max(beside) > 2 * CLICK:
        marks.append(behind[int(np.argmax(beside))])
    return [(round(float(x), 1), round(float(y), 1)) for x, y in marks]
