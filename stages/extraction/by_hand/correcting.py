"""One input folder being corrected: what the page asks for, as plain data. Knows nothing of HTTP."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.config.own_scene import write_config
from stages.contracts import InputError, atomic, read_json, write_json
from stages.contracts.objects import object_ids
from stages.contracts.scene_input import read_scene_input
from stages.extraction.by_hand.corrections import (
    CORRECTIONS,
    FLOOR,
    ROOM,
    WALL,
    Corrections,
    Cutter,
    as_found,
    bounds,
    corrected,
    painted,
)
from stages.extraction.by_hand.session import Answer, jpeg
from stages.extraction.by_hand.write import tinted

KEPT = ("rgb.png", "camera.json", "depth.npz")
CURVES, SMALLEST = 20, 12  # outlines of one thing that are shown, and the least pixels of one
COARSE = 1.0  # pixels by which a shown outline may be off


@dataclass
class Correction:
    """The folder with what was found, the one that is written, and what completes labels."""

    source: Path
    folder: Path
    categories: list[str] = field(default_factory=list)
    finished: bool = False
    page: str = "correct.html"

    def __post_init__(self) -> None:
        self.given = read_scene_input(self.source)
        self._cut = Cutter(self.given.rgb)
        self.posts: dict[str, Callable[[Any], Answer]] = {
            "solve": self.solve,
            "save": self.save,
            "write": self.write,
            "close": self.close,
        }

    def fresh(self) -> Corrections:
        """What was found."""
        return as_found(self.source.name, self.given.masks, self.given.annotations)

    def opened(self) -> Corrections:
        """The corrections that were saved, or what was found.

        Raises:
            InputError: what was saved is broken, or of another folder.
        """
        path = self.folder / CORRECTIONS
        if not path.is_file():
            return self.fresh()
        return self._checked(read_json(Corrections, path, "move it away to begin anew"), path)

    def _checked(self, drawing: Corrections, name: object) -> Corrections:
        height, width = self.given.masks.shape
        known = {item.found for item in self.fresh().objects}
        found = {item.found for item in drawing.objects} - {None}
        if (drawing.width, drawing.height) != (width, height) or not found <= known:
            what = f"is not of what {self.source} holds now."
            raise InputError(str(name), what, "give another --out, or move it away to begin anew")
        return drawing

    def start(self) -> Answer:
        """What the page begins with."""
        return {
            "project": self.opened().model_dump(mode="json"),
            "categories": [*self.categories, FLOOR, WALL],
            "folder": str(self.folder),
        }

    def picture(self) -> bytes:
        """The picture as JPEG."""
        return jpeg(self.given.rgb)

    def preview(self) -> bytes:
        """The saved masks over the picture, as JPEG."""
        drawing = self.opened()
        masks, values = painted(drawing, self.given.masks, self._cut)
        return jpeg(
            tinted(self.given.rgb, masks, [values[item.id] for item in drawing.objects if item.label not in ROOM])
        )

    def _project(self, body: Any) -> Corrections:
        return self._checked(Corrections.model_validate(body), "what was drawn")

    def solve(self, body: Any) -> Answer:
        """Box and outlines of every region."""
        drawing = self._project(body)
        masks, values = painted(drawing, self.given.masks, self._cut)
        regions, notes = {}, {}
        for item in drawing.objects:
            mask = masks == values[item.id]
            if not mask.any():
                notes[item.id] = "no pixel shows it"
            regions[item.id] = {"box": item.box or bounds(mask), "outlines": outlines(mask)}
        return {"regions": regions, "notes": notes}

    def save(self, body: Any) -> Answer:
        """Keep the corrections."""
        write_json(self.folder / CORRECTIONS, self._project(body))
        return {}

    def write(self, body: Any) -> Answer:
        """Keep the corrections and write the input folder.

        Raises:
            InputError: no object is left.
        """
        drawing = self._project(body)
        self.save(body)
        masks, values = painted(drawing, self.given.masks, self._cut)
        masks, annotations, notes = corrected(drawing, masks, values, self.given.annotations)
        if annotations is None:
            raise InputError(str(self.folder), "no object is left.", "draw a box around at least one")
        for name in KEPT:
            with atomic(self.folder / name) as path:
                shutil.copyfile(self.source / name, path)
        with atomic(self.folder / "masks.png") as path:
            cv2.imwrite(str(path), masks)
        write_json(self.folder / "annotations.json", annotations)
        write_config(self.folder)
        ids = object_ids(item.label for item in annotations.objects)
        command = f"snakemake --cores 2 --configfile {self.folder / 'config.yaml'} -- pages"
        return {"ids": ids, "notes": notes, "command": command, "folder": str(self.folder)}

    def close(self, _: Any) -> Answer:
        """The page is done with."""
        self.finished = True
        return {}


def outlines(mask: NDArray[np.bool_]) -> list[list[list[int]]]:
    """The largest outlines of a mask, as lists of pixels."""
    curves, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    largest = sorted(curves, key=cv2.contourArea, reverse=True)[:CURVES]
    kept = [curve for k, curve in enumerate(largest) if k == 0 or cv2.contourArea(curve) >= SMALLEST]
    return [cv2.approxPolyDP(curve, COARSE, True)[:, 0].tolist() for curve in kept]
