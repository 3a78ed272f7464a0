"""Session of the page that draws into a picture: its requests and answers as plain data, without HTTP."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from roomkin.plugins.annotator.clicking import OUTLINES, Clicked
from roomkin.plugins.annotator.described import describe_room, jpeg, rectify_front
from roomkin.plugins.annotator.kept import Kept
from roomkin.plugins.annotator.last_run import find_picture
from roomkin.stages.config.inputs import scene_of_folder
from roomkin.stages.contracts import Camera, InputError, read_json
from roomkin.stages.contracts.hand import PROJECT, find_hand_file
from roomkin.stages.contracts.types import Pixel
from roomkin.stages.geometry.boxes import extents, front_corners
from roomkin.stages.perception.camera.perspective import propose, usual_focal
from roomkin.stages.perception.classification.propose import Names
from roomkin.stages.perception.drawing.outlined import propose_box, support_at, weigh_names
from roomkin.stages.perception.drawing.paint import find_hidden, paint
from roomkin.stages.perception.drawing.project import DrawnObject, Project
from roomkin.stages.perception.drawing.solve import Solved
from roomkin.stages.perception.drawing.write import finish_drawing, side_angle, tint_picture, write_folder
from roomkin.stages.perception.read.photo import Photo
from roomkin.stages.perception.write import check_folder, is_clone, to_run

UNSEEN = "nothing of it would be seen in the picture: it lies behind something, or outside; it is left out"
UNCOUNTED = "opens: how many doors and drawers has it?"
NEW = "new"  # id of what is not drawn yet
Answer = dict[str, Any]


@dataclass
class Session(Clicked):
    """The picture, the folder that is written, and what completes labels."""

    photo: Photo
    name: str
    folder: Path
    categories: list[str] = field(default_factory=list)
    depth: NDArray[np.float32] | None = None
    page: ClassVar[str] = "page.html"
    # What the page may ask for.
    posts: ClassVar = ("solve", "save", "support", "front", "outline", "names", "place", "write", "close")

    def __post_init__(self) -> None:
        height, width = self.photo.rgb.shape[:2]
        self._proposed = propose(self.photo.rgb, usual_focal(width, height, self.photo.focal))
        self.kept = Kept(find_hand_file(self.folder, PROJECT, lambda: self.photo.digest))
        check_folder(self.folder, self.photo.digest)

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """The picture (H, W, 3)."""
        return self.photo.rgb

    def start_drawing(self) -> Project:
        """A drawing with nothing in it but the proposed perspective."""
        height, width = self.photo.rgb.shape[:2]
        about = {"picture": self.name, "digest": self.photo.digest, "width": width, "height": height}
        project = Project.model_validate(about | {"perspective": self._proposed})
        if self.depth is not None:
            project.scale.kind = "depth"
        return project

    def open_drawing(self) -> Project:
        """The drawing that was saved, that of the networks, or a fresh one.

        Raises:
            InputError: what was saved is broken, or of another picture.
        """
        mend = "move it away to begin anew"
        for path in filter(Path.is_file, (self.kept.path, self.folder / PROJECT)):
            project = read_json(Project, path, mend)
            if path == self.kept.path or project.digest == self.photo.digest:
                return self._check(project, path, mend)
        return self.start_drawing()

    def _check(self, project: Project, where: object, mend: str) -> Project:
        height, width = self.photo.rgb.shape[:2]
        return project.check_picture(self.photo.digest, width, height, where, mend)

    def start(self) -> Answer:
        """What the page begins with."""
        height, width = self.photo.rgb.shape[:2]
        notes = []
        if self.photo.shrunk > 1:
            notes.append(f"The picture was made smaller, to {width} x {height} pixels.")
        if self.photo.focal:
            notes.append("The focal length is known from the photograph's EXIF data.")
        project, camera = self.open_drawing(), self.folder / "camera.json"
        if project.untouched and camera.is_file():
            notes += filter(None, [read_json(Camera, camera).note])  # how sure it is, by what found the drawing
        return {
            "project": project.model_dump(mode="json"),
            "fresh": self.start_drawing().model_dump(mode="json"),
            "categories": self.categories,
            "folder": str(self.folder),
            "notes": notes,
            "depth": self.depth is not None,
            "clicks": self.clicker is not None,
            "pictured": self.find_last_picture() is not None,
        }

    def preview(self) -> bytes:
        """The saved drawing's masks over the picture, as JPEG."""
        project, solved = finish_drawing(self.open_drawing(), self.depth)
        painted = paint(project, solved)
        return jpeg(tint_picture(self.photo.rgb, painted.masks, [painted.values[item.id] for item in project.objects]))

    def _project(self, body: Any) -> Project:
        return self._check(Project.model_validate(body), "drawing", "reload the page")

    def _finish(self, body: Any) -> tuple[Project, Solved]:
        return finish_drawing(self._project(body), self.depth)

    def solve(self, body: Any) -> Answer:
        """Where everything is, in metres and in pixels."""
        project, solved = self._finish(body)
        hidden = find_hidden(project, solved)
        asked = [(name, UNSEEN) for name in hidden] + [(name, UNCOUNTED) for name in find_uncounted(project)]
        for name, what in asked:
            solved.notes[name] = "; ".join(filter(None, [solved.notes.get(name), what]))
        return describe_room(project, solved) | {"beneath": find_carriers(project, solved, {*hidden, *solved.usual})}

    def save(self, body: Any) -> Answer:
        """Keep the drawing."""
        said = {"untouched": False, "digest": self.photo.digest, "picture": self.name}
        self.kept.write(self._project(body).model_copy(update=said))
        return {}

    def support(self, body: Any) -> Answer:
        """What is at a pixel that something could stand or hang on."""
        pixel = TypeAdapter(Pixel).validate_python(body["pixel"])
        return {"on": support_at(self._finish(body["project"])[1], pixel, bool(body.get("stands")))}

    def place(self, body: Any) -> Answer:
        """What an outlined thing stands or hangs on, and the marks of the box that it would be in."""
        project, solved = self._finish(body["project"])
        on, points = propose_box(project, solved, OUTLINES.validate_python(body["outlines"]), body["on"], body["label"])
        return {"on": on, "points": points}

    def weigh_names(self, names: Names, body: Any) -> Names:
        """The names with the size that it would have, of whatever name."""
        project = self._project(body["project"])
        place = self.place({**body, "label": ""})
        project.objects.append(DrawnObject(id=NEW, **place))
        solved = finish_drawing(project, self.depth)[1]
        box = solved.boxes.get(NEW)
        return names if box is None else weigh_names(names, place["on"] in solved.walls, box.size[0], box.size[2])

    def front(self, body: Any) -> Answer:
        """The real front of an object seen straight on."""
        project, solved = self._finish(body["project"])
        item = {one.id: one for one in project.objects}[body["id"]]
        if (box := solved.boxes.get(item.id)) is None:
            what, mend = "has no place yet.", "mark its front first"
            raise InputError(item.label or item.id, what, mend, code="E-OBJECT-UNPLACED")
        points = front_corners(box, box.yaw + side_angle(item.faces))
        return rectify_front(self.photo.rgb, solved.view.project(points), *extents(points))

    def write(self, body: Any) -> Answer:
        """Write the input folder of a drawing that was saved."""
        project, solved = self._finish(body)
        written = write_folder(self.folder, self.photo.rgb, project, solved, self.depth)
        uncounted = [f"{written.ids[name]}: {UNCOUNTED}" for name in find_uncounted(project) if name in written.ids]
        notes = [*written.notes, *uncounted]
        return {"ids": written.ids, "notes": notes, "command": self.command(), "folder": str(self.folder)}

    def command(self) -> str:
        """The command that makes scenes of the folder that was written."""
        config = (self.folder if is_clone() else self.folder.resolve()) / "config.yaml"
        return to_run(f"--cores 2 --configfile {config} -- pages")

    def find_last_picture(self) -> Path | None:
        """The scene of rank 1, as it was made of the folder."""
        return find_picture(Path("results/generation"), scene_of_folder(self.folder))


def find_uncounted(project: Project) -> list[str]:
    """Ids of what opens by nobody knows how many doors and drawers."""
    return [item.id for item in project.objects if item.articulated and item.doors + item.drawers == 0]


def find_carriers(project: Project, solved: Solved, doubted: Collection[str]) -> dict[str, str]:
    """The object whose top the foot of a doubted thing is seen on, by its id, where it is on something else."""
    found = {}
    for item in project.objects:
        if item.id in doubted and item.on not in solved.walls:
            others = replace(solved, boxes={name: box for name, box in solved.boxes.items() if name != item.id})
            (ax, ay), (bx, by) = item.points[:2]
            on = support_at(others, ((ax + bx) / 2, (ay + by) / 2))
            if on in solved.boxes and on != item.on:
                found[item.id] = on
    return found
