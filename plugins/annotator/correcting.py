"""Session of the page that corrects an input folder: requests and answers as plain data, without HTTP."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.annotator.clicking import Clicked
from roomkin.plugins.annotator.cures import Cure, find_beneath, list_cures, match_walls
from roomkin.plugins.annotator.described import jpeg, rectify_front
from roomkin.plugins.annotator.kept import Kept
from roomkin.plugins.annotator.last_run import LastRun, describe_doubt, read_last_run
from roomkin.plugins.annotator.said import (
    Said,
    ShownPicture,
    ShownThing,
    find_changes,
    is_bare,
    name_drawn,
    read_bare,
    view_room,
    write_masks,
)
from roomkin.plugins.annotator.session import Answer
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.hand import Correction, Corrections, is_drawn
from roomkin.stages.contracts.objects import Wall, object_ids
from roomkin.stages.contracts.parts import says_opening
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.contracts.scenes import Held
from roomkin.stages.contracts.things import read_things
from roomkin.stages.contracts.types import FLOOR, WALL
from roomkin.stages.extraction.corrected_masks import (
    ROOM,
    CorrectedMasks,
    Cutter,
    apply_corrections,
    correct_masks,
    find_corners,
    list_found,
    list_losses,
    paint_masks,
)
from roomkin.stages.geometry.boxes import extents
from roomkin.stages.geometry.masks import outline_mask
from roomkin.stages.perception.drawing.write import tint_picture
from roomkin.stages.perception.segmentation.proposal import RoomView
from roomkin.stages.perception.write import is_clone, to_run

STILL = (0.0, 0.0)  # metres: not moved by hand


@dataclass
class Correcting(Clicked):
    """The input folder, the labels that the page completes, and the results of the last run."""

    folder: Path
    categories: list[str] = field(default_factory=list)
    results: Path = Path("results")
    scene: str = ""
    variant: str | None = None
    chosen: str | None = None
    page: ClassVar[str] = "correct.html"
    # What the page may ask for.
    posts: ClassVar[tuple[str, ...]] = ("solve", "save", "models", "front", "outline", "names", "write", "close")

    def __post_init__(self) -> None:
        self.given = read_bare(self.folder) if is_bare(self.folder) else read_scene_input(self.folder)
        self.found = list_found(self.given.annotations)
        things = None if is_drawn(self.folder) else read_things(self.folder)  # the drawing page takes them
        self.left_out = {item.mask: item for item in things.left_out if item.mask not in self.found} if things else {}
        self._said = Said(self.folder)
        self.kept = Kept(self._said.path)
        self._cut = Cutter(self.given.rgb)
        height, width = self.given.masks.shape
        self._moved: dict[int, tuple[float, float]] = {}  # by hand, before the page was opened
        self._walls: dict[int, Wall] = {}  # of the last run, by mask value
        self.made: LastRun = read_last_run(self.results, self.scene, self.variant, (width, height))

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """The picture (H, W, 3)."""
        return self.given.rgb

    @property
    def room(self) -> RoomView | None:
        """The room that depth shows."""
        return view_room(self.given.rgb, self.given.depth, self.given.camera)

    def open_drawing(self) -> ShownPicture:
        """What was found, with the corrections that were saved.

        Raises:
            InputError: what was saved is broken.
        """
        corrections, unmatched = self._said.read(self.given.masks)
        things = apply_corrections(self.found, corrections)
        # ids stay, whatever a thing is called: as found, or `drawn_<mask>`
        ids = dict(zip(self.found, object_ids(item.label or "" for item in self.found.values()), strict=True))
        found = set(np.unique(self.given.masks).tolist())
        shown = {mask: item for mask, item in things.items() if mask in found or item.is_drawn}
        things_shown = [ShownThing(id=ids.get(k, name_drawn(k)), **item.model_dump()) for k, item in shown.items()]
        return ShownPicture(objects=things_shown, unmatched=unmatched)

    def corrections(self, drawing: ShownPicture) -> Corrections:
        """The differences between a drawing and what was found."""
        things = {item.mask: item for item in drawing.objects}
        shown = set(np.unique(self.given.masks).tolist())
        shown -= {mask for item in drawing.objects for mask in item.joins}
        corrections = [Correction(mask=mask, gone=True) for mask in self.found if mask in shown and mask not in things]
        for mask, item in things.items():
            changes = find_changes(self.found.get(mask, Correction(mask=mask)), item)
            if changes or mask not in self.found:
                corrections.append(Correction.model_validate({"mask": mask, **changes}))
        labels = {mask: item.label or "" for mask, item in self.found.items()}
        labels |= {mask: item.names[0].name for mask, item in self.left_out.items() if item.names}
        return self._said.state(corrections, drawing.unmatched, self.given.masks, labels)

    def start(self) -> Answer:
        """What the page begins with."""
        drawing = self.open_drawing()
        self._moved = {item.mask: item.nudge for item in drawing.objects if item.nudge is not None}
        ids = {item.mask: item.id for item in drawing.objects}
        masks = {item.id: mask for mask, item in self.made.items.items()}
        known = {*ids.values(), *map(name_drawn, self.left_out)}
        cure = self._cure_by(drawing)
        doubts = {  # what the input itself doubts: there before the first run
            str(item.mask): {"doubts": [describe_doubt(one, cure(one, item.mask)) for one in item.doubts]}
            for item in self.given.annotations.objects
            if item.doubts
        }
        height, width = self.given.masks.shape
        about = {"picture": self.given.camera.picture or self.scene, "width": width, "height": height}
        return {
            "project": about | drawing.model_dump(mode="json"),
            "categories": [*self.categories, FLOOR, WALL],
            "folder": str(self.kept.path),
            "made": doubts | {str(mask): self.made.describe(item, cure) for mask, item in self.made.items.items()},
            "pictured": self.made.picture is not None,
            "chosen": ids.get(masks.get(self.chosen or "", 0), self.chosen if self.chosen in known else None),
            "offers": self._offer_things(),
            "proposals": {item.mask: item.proposals for item in self.given.annotations.objects}
            | {mask: [name.name for name in item.names] for mask, item in self.left_out.items()},
            "known": list(self.found),
            "free": int(max(self.given.masks.max(), *self.found, *ids)) + 1,
            "command": self.command(),
            "clicks": self.clicker is not None,
        }

    def _cure_by(self, drawing: ShownPicture) -> Callable[[Doubt, int], list[Cure]]:
        """What one click does against a doubt about the thing of a mask."""
        painted = self._paint_drawing(drawing).masks
        masks = np.where(painted > 0, painted, self.given.masks)  # with what was left out
        room = {item.mask: item.label for item in drawing.objects if item.label in ROOM}
        shown = {mask: masks == mask for mask, label in room.items() if label == WALL}
        self._walls = match_walls(self.made.objects, self.given.depth, shown) if self.made.objects else {}

        def cure(doubt: Doubt, mask: int) -> list[Cure]:
            placed = self.made.placed.get(mask)
            size = self.made.sizes.get(placed.asset) if placed else None
            moved = self._moved.get(mask, STILL)
            return list_cures(doubt, partial(find_beneath, masks, mask), self._walls, moved, placed, size, room)

        return cure

    def _offer_things(self) -> list[Answer]:
        """What was found and left out of the scene, with what a click makes of it."""
        return [
            {
                "id": name_drawn(mask),
                "mask": mask,
                "text": item.guess,
                "why": item.left_out,
                "outlines": outline_mask(self.given.masks == mask),
                "label": (name := item.names[0].name if item.names else None),
                "articulated": says_opening(name or "") or None,
            }
            for mask, item in self.left_out.items()
            if (self.given.masks == mask).any()
        ]

    def command(self) -> str:
        """The command that runs again what depends on the corrections."""
        config = self.folder / "config.yaml"
        page = f"results/report/scenes/{self.scene}.html"
        config = config if is_clone() else config.resolve()
        return to_run(f"--cores 2 --configfile {config} -- pages" if config.is_file() else f"--cores 2 {page}")

    def find_last_picture(self) -> Path | None:
        """The scene of rank 1, as the last run made it."""
        return self.made.picture

    def preview(self) -> bytes:
        """The saved masks over the picture, as JPEG."""
        drawing = self.open_drawing()
        things = [item.mask for item in drawing.objects if item.label not in ROOM]
        return jpeg(tint_picture(self.given.rgb, self._paint_drawing(drawing).masks, things))

    def _paint_drawing(self, drawing: ShownPicture) -> CorrectedMasks:
        return paint_masks({item.mask: item for item in drawing.objects}, self.given.masks, self._cut)

    def _drawing(self, body: Any) -> ShownPicture:
        return ShownPicture.model_validate({key: body[key] for key in ShownPicture.model_fields})

    def solve(self, body: Any) -> Answer:
        """Bounds and outlines of every region, and the sides of what stands there, as it will after the next run."""
        drawing = self._drawing(body)
        painted = self._paint_drawing(drawing)
        losses, regions = list_losses({item.mask: item for item in drawing.objects}, painted), {}
        for item in drawing.objects:
            mask = painted.masks == item.mask
            box, held = item.around or find_corners(mask), item.mounting
            wall = self._walls.get(held.walls[0]) if isinstance(held, Held) and held.type == 1 else None
            moved, at = self._moved.get(item.mask, STILL), (wall, box) if wall and box else None
            regions[item.id] = {"box": box, "outlines": outline_mask(mask), "faces": self.made.faces(item, moved, at)}
        notes = {item.id: losses[item.mask] for item in drawing.objects if item.mask in losses}
        covered = [item.id for item in drawing.objects if item.mask in painted.swallowed]
        return {"regions": regions, "notes": notes, "covered": covered}

    def models(self, body: Any) -> Answer:
        """Models that can stand for a thing, with pictures and distances."""
        return {"models": self.made.models(int(body["mask"]))}

    def front(self, body: Any) -> Answer:
        """The front of an object seen straight on; before the first run, the object's part of the picture."""
        drawing = self._drawing(body)
        item = {one.mask: one for one in drawing.objects}[body["mask"]]
        if (known := self.made.front(item.mask, item.front)) is not None:
            return rectify_front(self.given.rgb, *known)
        around = item.around or find_corners(self._paint_drawing(drawing).masks == item.mask)
        (x0, y0), (x1, y1) = around or ((0, 0), (1, 1))
        points = np.array([(x0, y1), (x1, y1), (x1, y0), (x0, y0)], float)
        return rectify_front(self.given.rgb, points, *extents(points))

    def save(self, body: Any) -> Answer:
        """Keep the corrections; where nothing ever was corrected there is no file."""
        self._keep(self._drawing(body))
        return {}

    def _keep(self, drawing: ShownPicture) -> None:
        told = self.corrections(drawing)
        if told.is_any or self.kept.path.is_file():  # one in which all is taken back tells by its age what changed
            self.kept.write(told.as_document())

    def write(self, body: Any) -> Answer:
        """Say what corrections that were saved change; a folder without masks gets them.

        Raises:
            InputError: no object is left.
        """
        corrections = {item.mask: item for item in self.corrections(self._drawing(body)).objects}
        annotations, masks, notes = correct_masks(self.given.annotations, self.given.masks, corrections, self._cut)
        if annotations is None:
            what, mend = "no object is left.", "draw a box around at least one"
            raise InputError(str(self.folder), what, mend, code="E-SCENE-EMPTY")
        if is_bare(self.folder):
            with self.kept.lock:
                latest = self.open_drawing()  # more may have been saved by now
                write_masks(self.folder, self.given, masks, annotations)
                self.given = read_scene_input(self.folder)
                self.found = list_found(self.given.annotations)
                self._keep(latest)
        ordered = sorted(annotations.objects, key=lambda item: item.mask)
        ids = object_ids(item.label for item in ordered)
        return {"ids": ids, "notes": notes, "command": self.command(), "folder": str(self.folder)}
