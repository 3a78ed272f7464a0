"""What a person says: `corrections.json` beside a scene's input, `project.json`, and where this work is kept."""

import json
import os
import re
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, Document, digest_of, read_json, read_text, write_json
from roomkin.stages.contracts.parts import Panel, check_counts
from roomkin.stages.contracts.scenes import Camera, Held
from roomkin.stages.contracts.types import (
    Angle,
    Coordinate,
    Id,
    Length,
    MaskValue,
    Outline,
    Panels,
    Pixel,
    Side,
    Text,
    check_supports,
    check_unique,
)

CORRECTIONS = "corrections.json"
MEASURED = "measured"
FLOOR = "floor"
Reader = Literal["extraction", "generation"]


class Correction(Contract):
    """One thing, the floor or a wall. What is left out, or null, stays as it was found."""

    mask: MaskValue = Field(description="its value in masks.png; one that is not in there: a thing that was not found")
    gone: bool = Field(False, description="it is no thing of its own")
    label: Text | None = Field(None, description="floor and wall mean what they say")
    named: bool = Field(False, description="a person says its name, be it the one that was proposed: it is not doubted")
    around: tuple[Pixel, Pixel] | None = Field(
        None, description="opposite corners of what shows it; cut out of the picture"
    )
    outline: Outline = Field([], description="the pixels that show it")
    pieces: list[Outline] = Field([], max_length=50, description="further outlines, where what is before it cuts it")
    layer: int = Field(0, ge=-1000, le=1000, description="what has more covers what has less")
    joins: list[MaskValue] = Field([], max_length=1000, description="masks that show further parts of it")
    articulated: bool | None = None
    doors: Panels | None = None
    drawers: Panels | None = None
    panels: list[Panel] | None = Field(
        None, max_length=1000, description="where doors and drawers lie on its front, and so how many; []: only counts"
    )
    mounting: Held | Literal["measured"] | None = Field(None, description="how it is held; measured: geometry tells")
    on: MaskValue | Literal["floor"] | None = Field(None, description="what it stands on")
    size: tuple[Length, Length, Length] | None = Field(None, description="width along its front, depth, height; metres")
    front: Angle | None = Field(None, description="direction that it faces about z; 0: as the camera looks; radians")
    nudge: tuple[Coordinate, Coordinate] | None = Field(
        None, description="how far it is moved with all that stands on it: away from the camera, to the left; metres"
    )
    model: Id | None = Field(None, description="the asset at rank 1, before those that matching ranked")
    pinned: bool = Field(False, description="`model` stands at every rank")
    banned: list[Id] = Field([], max_length=1000, description="assets that do not stand for it")
    like: MaskValue | None = Field(None, description="the thing whose model it has, at every rank")

    @property
    def outlines(self) -> list[list[Pixel]]:
        """Its outline, and those of its further pieces."""
        return [points for points in (self.outline, *self.pieces) if len(points) > 2]

    @property
    def is_drawn(self) -> bool:
        """Whether its pixels are not as they were found."""
        return self.around is not None or bool(self.outlines or self.joins)

    @property
    def named_masks(self) -> set[int]:
        """The masks that it speaks of."""
        walls = self.mounting.walls if isinstance(self.mounting, Held) else []
        others = [one for one in (self.on, self.like) if isinstance(one, int)]
        return {self.mask, *self.joins, *others, *walls}

    def read_by(self, stage: Reader) -> "Correction | None":
        """What of it concerns a stage; None: nothing."""
        kept = self.model_dump(include={"mask", *READ[stage]}, exclude_defaults=True)
        return Correction.model_validate(kept) if len(kept) > 1 else None

    @model_validator(mode="after")
    def _one_model(self) -> "Correction":
        check_counts(f"mask {self.mask}", self.panels or [], self.doors, self.drawers)
        check_unique(f"banned of mask {self.mask}", self.banned)
        if self.model is not None and (self.like is not None or self.model in self.banned):
            raise ValueError(f"model: of mask {self.mask} is banned, or that of `like`: say one of them")
        return self


PLACED = {"nudge", "model", "pinned", "banned", "like"}  # read by generation alone
READ: dict[Reader, set[str]] = {"extraction": set(Correction.model_fields) - PLACED - {"mask"}, "generation": PLACED}


class Shown(Contract):
    """What a mask showed when a person spoke of it."""

    mask: MaskValue
    label: str = Field("", max_length=1000, description="what it was called")
    outlines: list[Outline] = Field(min_length=1, max_length=51, description="of its pixels, the largest piece first")


class Unmatched(Contract):
    """A correction, or a part of one, of what was not found again; kept for when it is."""

    correction: Correction
    shown: list[Shown] = Field(max_length=1000, description="of the masks that it names, as it numbers them")


class Corrections(Document):
    """`corrections.json`; without it nothing is corrected. Mask values are those of the masks whose digest it has.

    Without a digest they are those of the masks.png that is there.
    """

    digest: str = Field("", pattern="^([0-9a-f]{64})?$", description="SHA-256 of the picture's file")
    size: tuple[Side, Side] | None = Field(None, description="width and height of the picture in which outlines are")
    masks: str = Field("", pattern="^([0-9a-f]{64})?$", description="SHA-256 of the mask values, see `digest_masks`")
    shown: list[Shown] = Field([], max_length=1000, description="what the masks show that corrections name")
    objects: list[Correction] = Field([], max_length=1000)
    unmatched: list[Unmatched] = Field([], max_length=1000)

    @model_validator(mode="after")
    def _check_references(self) -> "Corrections":
        check_unique("shown: mask values", [one.mask for one in self.shown])
        check_unique("objects: mask values", [item.mask for item in self.objects])
        joined = [mask for item in self.objects for mask in item.joins]
        check_unique("objects: masks that are joined", [*joined, *(item.mask for item in self.objects if item.joins)])
        check_supports(self._chain("on"), (FLOOR,))
        check_supports(self._chain("like"), (FLOOR,))
        return self

    def _chain(self, key: str) -> dict[str, str]:
        """From mask value to mask value, as text; a thing of which nothing is stated stands on the floor."""
        stated = {str(item.mask): str(getattr(item, key)) for item in self.objects if getattr(item, key) is not None}
        return dict.fromkeys(stated.values(), FLOOR) | stated

    def as_document(self) -> dict[str, Any]:
        """The file's content, without what is not said."""
        return {"version": 1, **self.model_dump(mode="json", exclude_defaults=True)}

    @property
    def is_any(self) -> bool:
        """Whether it says anything."""
        return bool(self.objects or self.unmatched)

    def read_by(self, stage: Reader) -> "Corrections":
        """The corrections that concern a stage, no others."""
        objects = [part for item in self.objects if (part := item.read_by(stage))]
        unmatched = [
            Unmatched(correction=part, shown=[each for each in one.shown if each.mask in part.named_masks])
            for one in self.unmatched
            if (part := one.correction.read_by(stage))
        ]
        named = {mask for item in objects for mask in item.named_masks}
        shown = [one for one in self.shown if one.mask in named]
        return self.model_copy(update={"objects": objects, "unmatched": unmatched, "shown": shown})


def read_corrections(paths: Iterable[Path]) -> Corrections:
    """What corrections.json says; `paths`: the file, or nothing.

    Raises:
        InputError: it is broken.
    """
    return next((read_json(Corrections, path, "mend or delete it") for path in paths), Corrections())


HAND = "hand"  # the folder beside results/ that no command deletes
PROJECT = "project.json"  # a drawing; corrections.json: `roomkin.stages.contracts.hand`
# Input folders that the workflow makes: what is before results/, the scene's name.
MADE = re.compile(r"(.*/)?results/(?:photo/([^/]+)|scenes/([^/]+)/(?:view|frame|input))")


def hand_folder(folder: Path) -> Path:
    """Where what a person does to an input folder is kept: there, or in hand/<scene>/ for one that the workflow makes.

    Those are results/photo/<scene> and results/scenes/<scene>/{view,frame,input}; hand/ stands beside results/.
    """
    for path in (folder, folder.absolute()):
        if found := MADE.fullmatch(Path(os.path.normpath(path)).as_posix()):
            return Path(found[1] or "", HAND, found[2] or found[3])
    return folder


def find_hand_file(folder: Path, name: str, picture: Callable[[], str]) -> Path:
    """Where a person's file about the picture of an input folder is, or will be.

    If the file of that name is of another picture, one with this one's digest in its name. What an older version left
    among results is moved, with a line.

    Args:
        folder: the input folder.
        name: corrections.json or project.json.
        picture: what tells SHA-256 of the picture's file, "" if it is not there yet; asked where a file is there.
    """
    path, old = hand_folder(folder) / name, folder / name
    if path != old and is_by_hand(old) and path.exists():
        print(f"{old}: not used: {path} is", file=sys.stderr)
    elif path != old and is_by_hand(old):
        path.parent.mkdir(parents=True, exist_ok=True)
        if name == CORRECTIONS:
            _name_masks(old)
        old.rename(path)
        print(f"{old}: moved to {path}, where no command deletes what a person did", file=sys.stderr)
    known = _look(path).get("digest")
    if not known or (digest := picture()) in ("", known):
        return path
    return path.with_suffix(f".{digest[:8]}{path.suffix}")


def _name_masks(path: Path) -> None:
    """Write into corrections.json of an older version what the masks beside it show, by whose numbers alone it goes."""
    from roomkin.stages.contracts.matched import (  # OpenCV, which no other start of a workflow needs
        digest_masks,
        show_masks,
    )
    from roomkin.stages.contracts.scene_input import read_annotations

    with suppress(InputError, OSError):
        said, (annotations, masks) = read_json(Corrections, path), read_annotations(path.with_name("annotations.json"))
        named = {mask for item in said.objects for mask in item.named_masks}
        shown = show_masks(named, masks, {item.mask: item.label for item in annotations.objects})
        about = {"size": masks.shape[::-1], "masks": digest_masks(masks), "shown": shown}
        write_json(path, said.model_copy(update={} if said.masks else about).as_document())


def is_by_hand(path: Path) -> bool:
    """Whether a file is there that a person made: corrections, or a drawing that is not the networks' alone."""
    return path.is_file() and not _look(path).get("untouched", False)


def digest_of_image(path: Path) -> str:
    """SHA-256 of a picture's file; of rgb.png in an input folder, that of the file that it was read from."""
    known = _look(path.with_name("camera.json")).get("digest") if path.name == "rgb.png" else ""
    return known if known and isinstance(known, str) else digest_of(path)


def digest_of_picture(folder: Path) -> str:
    """SHA-256 of the file that the picture of an input folder was read from: as camera.json says, else of rgb.png.

    Raises:
        InputError: camera.json is broken.
    """
    camera = folder / "camera.json"
    known = read_json(Camera, camera).digest if camera.is_file() else ""
    return known or digest_of(folder / "rgb.png")


def _look(path: Path) -> dict[str, Any]:
    """The keys of a file, unchecked; none if it is not there or broken, which its reader tells."""
    with suppress(InputError, ValueError, RecursionError):
        found = json.loads(read_text(path))
        return found if isinstance(found, dict) else {}
    return {}
