"""Solve a drawing: camera, walls and boxes in metres."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.categories import usual_depth
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.images import NEAREST
from roomkin.stages.contracts.types import LARGEST, Pixel
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import yaw_matrix
from roomkin.stages.perception.camera.metrology import (
    DRAWING_ERROR,
    FLAT_DEPTH,
    MetrologyError,
    PinholeView,
    RearCornerError,
    UprightPlane,
    fit_hanging_box,
    fit_standing_box,
    round_box,
    wall_plane,
)
from roomkin.stages.perception.camera.perspective import fit_view
from roomkin.stages.perception.drawing.project import (
    CAMERA_HEIGHT,
    DrawnObject,
    Project,
    Scale,
    Sides,
    camera_factor,
    describe_odd,
    find_usual_size,
    is_edge_marked,
)
from roomkin.stages.perception.layout.walls import end_walls

NEARER = 0.7  # of its distance at least, at which something that was marked too high is put onto what carries it
NEAREST_GUESSED = 0.2  # likewise, where nobody drew how deep that is
UNSURE = "found by networks alone: put it right, or say that it is"


@dataclass(frozen=True)
class Solved:
    """The room in metres; `notes`: by id of an object or wall, or `scale`, what is wrong with it or was guessed;
    `guessed`: objects of which nobody drew or typed how deep they are; `usual`: of what is absurdly large, thin or
    small, the width, depth and height to take instead; `factor`: by which nearly all heights are wrong, with the
    height of a camera that nobody gave; `doubts`: what the notes say of a box that pages after a run are to say too.
    """

    view: PinholeView
    walls: dict[str, UprightPlane]
    boxes: dict[str, UprightBox]
    notes: dict[str, str] = field(default_factory=dict)
    guessed: set[str] = field(default_factory=set)
    usual: dict[str, Sides] = field(default_factory=dict)
    factor: float | None = None
    doubts: dict[str, list[Doubt]] = field(default_factory=dict)


def _is_depth_guessed(item: DrawnObject, hangs: bool) -> bool:
    """Whether nobody drew or typed how deep it is."""
    return len(item.points) < (3 if hangs else 4) and item.depth is None and not item.round


def _list_guessed(item: DrawnObject, hangs: bool) -> str:
    """What a box has that was neither drawn nor typed."""
    if not hangs and len(item.points) < 3 and item.height is None:
        return "height is missing: mark the front's upper edge, or type it"
    if _is_depth_guessed(item, hangs):
        return "depth is guessed: mark a rear corner, or type it"
    return ""


class _Room:
    """One pass over the drawing at one height of the camera."""

    def __init__(self, project: Project, view: PinholeView, typed: bool) -> None:
        self.view, self.typed = view, typed
        self.drawn = {item.id: item for item in project.objects}
        self.walls: dict[str, UprightPlane] = {}
        self.boxes: dict[str, UprightBox] = {}
        self.notes: dict[str, str] = {}
        self.guessed: set[str] = set()
        for wall in project.walls:
            try:
                self.walls[wall.id] = wall_plane(view, wall.a, wall.b, wall.free)
            except MetrologyError as error:
                self.notes[wall.id] = str(error)
        self.walls = end_walls(view, self.walls, {line.id: (line.a, line.b) for line in project.walls})
        for item in project.objects:
            self._place(item, ())

    def _place(self, item: DrawnObject, above: tuple[str, ...]) -> None:
        if item.id in self.boxes or item.id in self.notes:
            return
        if item.id in above:
            self.notes[item.id] = "stands on itself: choose what it stands on"
            return
        try:
            if _is_depth_guessed(item, item.on in self.walls):
                self.guessed.add(item.id)
            try:
                self.boxes[item.id] = self._box(item, item.points, above)
            except RearCornerError as error:
                self.guessed.add(item.id)
                seen = item.points[: 2 if item.on in self.walls else 3]
                self.boxes[item.id] = self._box(item, seen, above)
                self.notes[item.id] = f"{error}; its depth is guessed"
            if item.id in self.guessed and item.on not in self.walls:
                self.boxes[item.id] = self._trim_at_walls(self.boxes[item.id])
            if item.on in self.boxes:
                self._move_onto(item, self.boxes[item.on], above)
        except MetrologyError as error:
            self.notes.setdefault(item.id, str(error))

    def _box(self, item: DrawnObject, points: list[Pixel], above: tuple[str, ...]) -> UprightBox:
        sizes = item.sizes if self.typed else (None, None, None)
        deep = usual_depth(item.label) if self.typed else None
        if item.on in self.walls:
            return fit_hanging_box(self.view, self.walls[item.on], points[:3], sizes, deep or FLAT_DEPTH)
        ground = self._ground(item, above)
        if item.round:
            return round_box(self.view, ground, points, sizes)
        return fit_standing_box(self.view, ground, points, sizes, item.free, deep)

    def _trim_at_walls(self, box: UprightBox) -> UprightBox:
        """The box as deep as to the wall behind its front, if it would go through it."""
        inward = yaw_matrix(box.yaw) @ [0.0, 1.0, 0.0]
        width, depth, height = box.size
        front = box.center - inward * depth / 2
        for wall in self.walls.values():
            towards = float(inward @ wall.normal)
            gap = (wall.offset - float(front @ wall.normal)) / towards if towards < -0.5 else np.inf
            low, high = wall.ends
            if DRAWING_ERROR < gap < depth and low <= float((front + gap * inward) @ wall.along) <= high:
                depth = gap
        return UprightBox(front + inward * depth / 2, [width, depth, height], box.yaw)

    def _move_onto(self, item: DrawnObject, carrier: UprightBox, above: tuple[str, ...]) -> None:
        """Nearer along the line of sight, and smaller by as much, until its rear is over what carries it.

        On a level just below the eye a pixel is many centimetres: a foot that was marked little too high is far beyond,
        and its rear corner farther still. What is deeper than all that carries it says so of its rear corner.
        """
        box = self.boxes[item.id]
        c, s = np.cos(box.yaw - carrier.yaw), np.sin(box.yaw - carrier.yaw)
        marked = len(item.points) > 3 and item.depth is None and not item.round
        beyond = marked and box.size[1] > abs(c) * carrier.size[1] + abs(s) * carrier.size[0]
        if beyond:
            self.boxes[item.id] = self._box(item, item.points[:3], above)
            self.guessed.add(item.id)
        if not self._can_move_nearer(item, carrier):
            what = "stands beside what it should stand on: is that deep enough, and drawn up to its worktop?"
            self.notes.setdefault(item.id, what)
        elif beyond:
            self.notes[item.id] = "its rear corner lay beyond what it stands on; its depth is guessed"

    def _can_move_nearer(self, item: DrawnObject, carrier: UprightBox) -> bool:
        """Whether its rear could be put over what carries it."""
        box, eye = self.boxes[item.id], np.array([0, 0, self.view.above])
        nearest = NEAREST_GUESSED if item.on in self.guessed else NEARER
        for share in np.linspace(1, nearest, 31):
            sizes = zip(item.sizes if self.typed else (None,) * 3, box.size, strict=True)
            size = np.array([known or share * seen for known, seen in sizes])
            center = eye + share * (box.center - eye)
            if _is_over(carrier, center + yaw_matrix(box.yaw) @ [0, size[1] / 2, 0]):
                break
        else:
            return False
        if share < 1:
            if item.height is None:
                size[2] = max(center[2] + size[2] / 2 - carrier.top, size[2] / 2)
            center[2] = carrier.top + size[2] / 2
            self.boxes[item.id] = UprightBox(center, size, box.yaw)
            self.notes.setdefault(item.id, f"its base lay beyond what it stands on: {1 - share:.0%} nearer")
        return True

    def _ground(self, item: DrawnObject, above: tuple[str, ...]) -> float:
        if item.on == "floor":
            return 0.0
        if item.on not in self.drawn:
            raise MetrologyError("hangs on a wall or stands on an object that is not there")
        self._place(self.drawn[item.on], (*above, item.id))
        if item.on not in self.boxes:
            raise MetrologyError("what it stands on has no place yet")
        return self.boxes[item.on].top


def _cause(item: DrawnObject, room: _Room) -> str:
    """What may be behind an absurd size, as a question."""
    if item.on in room.walls:
        return "; does it hang on that wall?"
    return "; is what it stands on drawn up to its worktop?" if item.on in room.boxes else ""


def _height(project: Project, view: PinholeView) -> float:
    """Height of the camera in metres, from the known length; `view` is one metre above the floor.

    Raises:
        MetrologyError: the known length cannot be measured in the picture.
    """
    scale = project.scale
    metres = scale.metres or CAMERA_HEIGHT
    if scale.kind in ("camera", "depth"):
        return metres
    if scale.kind == "object":
        boxes = _Room(project, view, typed=False).boxes
        if scale.object not in boxes:
            raise MetrologyError("the object whose size is known has no place yet")
        return metres / float(boxes[scale.object].size[("width", "depth", "height").index(scale.side)])
    if scale.points is None:
        raise MetrologyError("draw the line whose length is known")
    return metres / _length(view, scale)


def _length(view: PinholeView, scale: Scale) -> float:
    """Length of a line on the floor, or straight up from it."""
    assert scale.points is not None
    foot = view.meet_level(scale.points[0])
    if scale.kind == "floor":
        return max(float(np.linalg.norm(view.meet_level(scale.points[1]) - foot)), 1e-4)
    away = foot / np.linalg.norm(foot)  # an upright plane that faces the camera, through the lower end
    top = view.meet_plane(scale.points[1], away, float(foot @ away))
    if top[2] <= 1e-4:
        raise MetrologyError("the line does not go up from the floor")
    return float(top[2])


def solve(project: Project) -> Solved:
    """Camera, walls and boxes of a drawing; what has no place says why in the notes, the rest goes on without it."""
    view = fit_view(project.perspective, project.width, project.height)
    notes = {}
    try:
        above = _height(project, view)
        if not NEAREST <= above <= LARGEST:
            raise MetrologyError(f"the camera would be {above:.3g} m above the floor")
    except MetrologyError as error:
        notes["scale"] = f"{error}; the camera is taken to be {CAMERA_HEIGHT} m above the floor"
        above = CAMERA_HEIGHT
    room = _Room(project, replace(view, above=above), typed=True)
    factor, usual = camera_factor(project, room.boxes), {}
    doubts: dict[str, list[Doubt]] = {}
    for item in project.objects:
        box = room.boxes.get(item.id)
        if box is not None and max(box.size) > LARGEST:
            room.notes[item.id] = f"would be {max(box.size):.0f} m large"
            del room.boxes[item.id]
        elif box is not None:
            odd = describe_odd(item, box, factor or 1.0)
            if odd and (instead := find_usual_size(item, box)):
                usual[item.id] = instead
                odd += _cause(item, room)
            hangs = item.on in room.walls
            edge, guess = is_edge_marked(box) if hangs else "", _list_guessed(item, hangs)
            lines = [UNSURE if item.unsure else "", edge, room.notes.get(item.id, guess), odd]
            if doubted := "; ".join(filter(None, [edge, room.notes.get(item.id, guess.partition(":")[0])])):
                moved = item.id in room.notes and item.id not in room.guessed and not edge
                doubts[item.id] = [Doubt(cause="place" if moved else "size", what=doubted)]
            room.notes |= {item.id: "; ".join(filter(None, lines))} if any(lines) else {}
    return Solved(room.view, room.walls, room.boxes, {**room.notes, **notes}, room.guessed, usual, factor, doubts)


def _is_over(box: UprightBox, point: NDArray[np.float64]) -> bool:
    """Whether a point lies over the footprint of a box."""
    c, s = np.cos(box.yaw), np.sin(box.yaw)
    dx, dy = (point - box.center)[:2]
    width, depth, _ = box.size
    return bool(abs(c * dx + s * dy) <= width / 2 and abs(-s * dx + c * dy) <= depth / 2)
