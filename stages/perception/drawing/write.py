"""Write a drawing as an input folder: rgb.png, camera.json, depth.npz, masks.png, annotations.json."""

from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.recordings import name_picture
from roomkin.stages.contracts import Annotations, Camera, InputError, write_json
from roomkin.stages.contracts.hand import PROJECT
from roomkin.stages.contracts.images import color_of
from roomkin.stages.contracts.objects import Box, object_ids
from roomkin.stages.contracts.scene_input import write_scene_input
from roomkin.stages.contracts.scenes import Annotation, Held
from roomkin.stages.contracts.things import THINGS, Found, Thing, Things
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import invert_transform, round_vector, transform_points, wrap_angle, yaw_of_matrix
from roomkin.stages.geometry.masks import polygons
from roomkin.stages.geometry.room_planes import STRAY, Plane, make_floor_frame
from roomkin.stages.perception.camera.metrology import PinholeView
from roomkin.stages.perception.drawing.paint import SPARSE, paint
from roomkin.stages.perception.drawing.project import DrawnObject, Project
from roomkin.stages.perception.drawing.solve import Solved, solve
from roomkin.stages.perception.read.frame import is_stretched
from roomkin.stages.perception.write import check_folder, doubt_name, is_clone, write_config

DRAWING = "drawing"  # what proposes the things of a drawing
SIDES = ("right", "rear", "left", "front")  # of a drawn box, counter-clockwise from its x axis


class Written(NamedTuple):
    """The folder's objects by their ids in the project, and lines for the person who draws."""

    ids: dict[str, str]
    notes: list[str]


def floor_from_camera(view: PinholeView) -> NDArray[np.float64]:
    """The camera in the floor frame of the contract: x along the view."""
    return make_floor_frame(Plane(view.rotation[2], -view.above, np.zeros(0, dtype=bool)))


def floor_box(view: PinholeView, box: UprightBox) -> Box:
    """A box of the room frame in the floor frame; its x axis is the side nearest to that frame's."""
    floor_from_room = floor_from_camera(view) @ invert_transform(view.room_from_camera)
    yaw = box.yaw + yaw_of_matrix(floor_from_room[:3, :3])
    turned = wrap_angle(yaw, np.pi / 2)
    width, depth, height = box.size
    if round((yaw - turned) / (np.pi / 2)) % 2:
        width, depth = depth, width
    size = round_vector([width, depth, height])
    return Box(center=round_vector(transform_points(floor_from_room, box.center)), size=size, yaw=round(turned, 6))


def front_of(view: PinholeView, box: UprightBox, side: str) -> float:
    """Direction about z, floor frame, of a side of a drawn box; its y axis goes back from what was drawn as front."""
    floor_from_room = floor_from_camera(view) @ invert_transform(view.room_from_camera)
    return round(wrap_angle(box.yaw + side_angle(side) + yaw_of_matrix(floor_from_room[:3, :3])), 6)


def side_angle(side: str) -> float:
    """Direction of a side of a drawn box, from its x axis."""
    return SIDES.index(side) * np.pi / 2


def with_scale_of(depth: NDArray[np.float32], project: Project) -> Project:
    """The drawing with the camera at the height that makes its floor agree with depth in metres.

    Raises:
        InputError: the depth shows too little of the floor that was drawn.
    """
    unit = project.model_copy(update={"scale": project.scale.model_copy(update={"kind": "camera", "metres": 1.0})})
    untyped = {"width": None, "depth": None, "height": None}
    flat = unit.model_copy(update={"objects": [item.model_copy(update=untyped) for item in unit.objects]})
    painted, depth = paint(flat, solve(flat), SPARSE), depth[::SPARSE, ::SPARSE]
    floor = (painted.masks == painted.values["floor"]) & (depth > 0) & (painted.depth > 0)
    if floor.mean() < STRAY:
        what, mend = "shows too little of the floor to tell the scale.", "give one known length on the page"
        raise InputError("--depth", what, mend, code="E-SCALE-UNKNOWN")
    metres = float(np.median(depth[floor] / painted.depth[floor]))
    return project.model_copy(update={"scale": project.scale.model_copy(update={"metres": round(metres, 4)})})


def finish_drawing(project: Project, depth: NDArray[np.float32] | None) -> tuple[Project, Solved]:
    """The drawing with its scale, solved."""
    if project.scale.kind == "depth":
        if depth is None:
            what = "takes its scale from depth, but none was given."
            raise InputError(PROJECT, what, "start with --depth", code="E-SCALE-UNKNOWN")
        project = with_scale_of(depth, project)
    return project, solve(project)


def _annotate(item: DrawnObject, values: dict[str, int], walls: list[int], solved: Solved) -> Annotation:
    """What is told of a thing, by mask values of all that was drawn and those of walls that are seen."""
    box, wall = solved.boxes[item.id], values.get(item.on)
    return Annotation(
        mask=values[item.id],
        label=item.label.strip() or "object",
        articulated=item.articulated or item.doors + item.drawers > 0,
        doors=item.doors,
        drawers=item.drawers,
        panels=item.panels,
        box=floor_box(solved.view, box),
        guessed=item.id in solved.guessed,
        front=None if item.round else front_of(solved.view, box, item.faces),
        mounting=Held(type=1, walls=[wall]) if wall in walls and not item.unsure else None,
        doubts=solved.doubts.get(item.id, []) + (doubt_name(item.names) if item.unsure else []),
        proposals=[one.name for one in item.names] if item.unsure else [],
    )


def _tell(found: Found, value: int, left_out: str = "") -> Thing:
    """A thing of a drawing with the names that nobody has confirmed."""
    return Thing(mask=value, names=found.names, other=found.other, source=DRAWING, left_out=left_out)


def write_folder(
    folder: Path,
    rgb: NDArray[np.uint8],
    project: Project,
    solved: Solved,
    depth: NDArray[np.float32] | None = None,
    note: str = "",
) -> Written:
    """Write the five files, things.json, and `config.yaml`, which names the folder as a scene of an experiment.

    Args:
        rgb: the upright picture (H, W, 3).
        solved: the drawing, solved.
        depth: (H, W) metres by a sensor or a network; None: the depth of what was drawn.
        note: how sure the camera is, for people.

    Raises:
        InputError: nothing was drawn, or nothing of it can be seen.
    """
    check_folder(folder, project.digest)
    placed = [item for item in project.objects if item.id in solved.boxes]
    painted = paint(project, solved)
    view, values = solved.view, painted.values
    shown = set(np.unique(painted.masks).tolist())
    seen = [item for item in placed if values[item.id] in shown]
    if not seen:
        what = "no object can be seen in the picture." if placed else "no object has a place yet."
        raise InputError(str(folder), what, "draw a box around something that is shown", code="E-SCENE-EMPTY")

    used = [values[name] for name in ["floor", *(item.id for item in seen), *(wall.id for wall in project.walls)]]
    masks = np.where(np.isin(painted.masks, used), painted.masks, 0)
    things = [_tell(item if item.unsure else Found(), values[item.id]) for item in seen]
    free = ~np.isin(masks, [thing.mask for thing in things])
    for value, one in enumerate(project.left_out, len(values) + 1):
        masks[free & polygons(one.outlines, masks.shape)] = value
        things.append(_tell(one, value, one.left_out))
    shown = set(np.unique(masks).tolist())
    about = {"note": note, "picture": name_picture(Path(project.picture)), "digest": project.digest}
    matrix, pose = view.intrinsics.tolist(), floor_from_camera(view).tolist()
    camera = Camera(width=view.width, height=view.height, intrinsics=matrix, floor_from_camera=pose, **about)
    walls = [values[wall.id] for wall in project.walls if values[wall.id] in shown]
    told, floor = [_annotate(item, values, walls, solved) for item in seen], values["floor"]
    annotations = Annotations(objects=told, floor=floor if floor in shown else None, walls=walls)
    write_json(folder / THINGS, Things(walls=len(annotations.walls), things=things))
    write_scene_input(folder, rgb, painted.depth if depth is None else depth, camera, masks, annotations)
    write_config(folder if is_clone() else folder.resolve())  # what is relative is so to the clone

    ids = dict(zip((item.id for item in seen), object_ids(item.label for item in annotations.objects), strict=True))
    labels = {item.id: item.label for item in project.objects if item.label}
    notes = [f"{ids.get(name) or labels.get(name, name)}: {text}" for name, text in solved.notes.items()]
    notes += [f"{ids[item.id]}: has no name: cousins are sought by its looks alone" for item in seen if not item.label]
    notes += [f"{item.label or item.id}: not in the picture, left out" for item in placed if item not in seen]
    return Written(ids, notes)


def tint_picture(rgb: NDArray[np.uint8], masks: NDArray[np.uint16], objects: list[int]) -> NDArray[np.uint8]:
    """The picture tinted by its masks, to show a person which pixels belong to which object.

    Args:
        objects: mask values of objects; what else has one is floor or wall, and tinted lightly.
    """
    tints = np.array([color_of(value) for value in range(int(masks.max()) + 1)])[masks]
    strength = np.where(np.isin(masks, objects), 0.55, np.where(masks > 0, 0.22, 0.0))[..., None]
    return np.rint(rgb * (1 - strength) + tints * strength).astype(np.uint8)


def at_size(depth: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """Depth laid on the picture's pixels.

    Raises:
        InputError: it has other proportions than the picture.
    """
    if is_stretched(depth.shape[::-1], (width, height)):
        what = f"is {depth.shape[1]}x{depth.shape[0]}, of other proportions than the picture ({width}x{height})."
        raise InputError("--depth", what, "it must cover the same view as the upright picture", code="E-DEPTH-SIZE")
    return np.asarray(cv2.resize(depth, (width, height), interpolation=cv2.INTER_NEAREST), dtype=np.float32)
