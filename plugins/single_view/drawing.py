"""A room as a drawing, as a person would have drawn it on the page: camera, walls and boxes with their outlines."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from plugins.annotator.clicking import outline_pieces
from plugins.annotator.fronts import front_corners
from plugins.annotator.outlined import FACING, Fit, area_of, mark_box
from plugins.annotator.project import DrawnObject, DrawnWall, Project, Scale
from plugins.inputs.photo.metrology import MetrologyError, View, WallPlane
from plugins.inputs.photo.perspective import fit_view, horizon
from plugins.single_view.room import Room
from stages.contracts.parts import says_opening
from stages.contracts.types import Pixel
from stages.geometry.boxes import UprightBox

REACH = 8.0  # metres of a wall to either side that are drawn
ALONG = 1e-6  # sine of what is no angle
AHEAD = 0.3  # metres before the camera, nearer than which nothing is drawn


def draw_room(
    name: str, room: Room, masks: NDArray[np.integer], labels: Mapping[int, str]
) -> tuple[Project, dict[int, str]]:
    """The drawing, and why the rest of the things are left out, by the values of their masks.

    Args:
        name: file name of the picture.
        masks: (H, W).
        labels: of the things, by the values of their masks.
    """
    height, width = masks.shape
    fixed = {"horizon": horizon(room.view), "focal": room.view.focal}
    perspective = room.perspective.model_copy(update=fixed)
    view = fit_view(perspective, width, height)
    view = View(width, height, view.focal, view.rotation, room.view.above)
    left_out, objects = dict(room.left_out), list[DrawnObject]()
    walls = [draw_wall(view, f"wall_{number}", wall) for number, wall in enumerate(room.walls, 1)]
    for value, box in room.boxes.items():
        on = room.on[value]
        try:
            points = mark_points(view, box, on < 0)
        except MetrologyError as error:
            left_out[value] = str(error)
            continue
        rings = outline_pieces(masks == value)
        holder = "floor" if on == 0 else f"wall_{-on}" if on < 0 else f"thing_{on}"
        objects.append(
            DrawnObject(
                id=f"thing_{value}",
                label=labels[value],
                on=holder,
                points=points,
                free=not along_room(box),
                depth=None if len(points) > (2 if on < 0 else 3) else round(float(box.size[1]), 3),
                articulated=says_opening(labels[value]),
                outline=rings[0] if rings else [],
                pieces=rings[1:],
                unsure=True,
            )
        )
    kept = keep_carried(objects, [wall.id for wall in walls if wall is not None])
    left_out |= {int(item.id[6:]): "what carries it has no place" for item in objects if item not in kept}
    project = Project(
        picture=name,
        width=width,
        height=height,
        perspective=perspective,
        scale=Scale(kind="camera", metres=round(room.view.above, 3)),
        walls=[wall for wall in walls if wall is not None],
        objects=kept,
        untouched=True,
    )
    return project, left_out


def keep_carried(objects: list[DrawnObject], walls: list[str]) -> list[DrawnObject]:
    """The objects that the floor, a wall, or another of them carries."""
    there = {"floor", *walls, *(item.id for item in objects)}
    kept = [item for item in objects if item.on in there]
    return kept if len(kept) == len(objects) else keep_carried(kept, walls)


def mark_points(view: View, box: UprightBox, hangs: bool) -> list[Pixel]:
    """The marks that make a box.

    Raises:
        MetrologyError: it reaches behind the camera.
    """
    if hangs:
        return mark_box(view, Fit(box, 0.0, False), box.yaw - np.pi / 2, hangs=True)
    sides = [box.yaw + angle for angle in FACING]
    seen = [area_of(view.project(front_corners(box, side))) for side in sides]
    return mark_box(view, Fit(box, 0.0, True), sides[int(np.argmax(seen))], hangs=False)


def along_room(box: UprightBox) -> bool:
    """Whether the sides of a box run along the axes of the room."""
    return abs(float(np.sin(2 * box.yaw))) < ALONG


def draw_wall(view: View, name: str, wall: WallPlane) -> DrawnWall | None:
    """A wall by two points of its foot; None: none lies before the camera."""
    feet = wall.offset * wall.normal + np.linspace(-REACH, REACH, 81)[:, None] * wall.along
    before = (feet - [0, 0, view.above]) @ view.rotation[:, 2] > AHEAD
    if before.sum() < 2:
        return None
    ends = view.project(feet[before][[0, -1]])
    a, b = ((round(float(x), 1), round(float(y), 1)) for x, y in ends)
    return DrawnWall(id=name, a=a, b=b)
