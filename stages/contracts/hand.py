"""A person's work on pictures, corrections.json and project.json: which picture it is of, and where it is kept."""

import json
import os
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from roomkin.stages.contracts.checksums import digest_of
from roomkin.stages.contracts.corrections import CORRECTIONS, Corrections
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, read_text, write_json
from roomkin.stages.contracts.scenes import Camera

HAND = "hand"  # the folder beside results/ that no command deletes
PROJECT = "project.json"  # a drawing; corrections.json: `roomkin.stages.contracts.corrections`
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
