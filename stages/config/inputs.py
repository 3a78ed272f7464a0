"""What a run looks at: rooms and pictures by their scenes' names, and section `extraction` (paper 2.1, A.2, A.7)."""

import json
import os
import re
import unicodedata
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from roomkin.stages.contracts.files import decode_file
from roomkin.stages.contracts.objects import USUAL_ERROR, object_ids
from roomkin.stages.contracts.parts import FRONTS
from roomkin.stages.contracts.section import KWARGS, Section

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9-]*(_[A-Za-z0-9-]+)*")  # becomes part of paths
LONGEST = 120  # bytes of a scene's name: logs are called by it and more, and a file's name has 255 at most
INPUT_FILES = ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json")
MADE = ("input", "frame")  # what input folders are called that the workflow makes in a folder of the scene's name
HOLDS = "docs/scenes.md says what an input folder holds"


def scene_of(path: Path) -> str:
    """The name of the scene of a file or folder: its own, if letters and digits of any script, - and single _ inside.

    Otherwise what it has of these, with a digest of it: no two names become one, but a name written in two ways (NFC).
    """
    name = unicodedata.normalize("NFC", path.name)
    own = ("Mn", "Mc")  # vowels and accents that are written as characters of their own
    kept = "".join(c if c == "-" or c.isalnum() or unicodedata.category(c) in own else " " for c in name)
    words = [word for word in kept.split() if any(each == "-" or each.isalnum() for each in word)]
    plain = "_".join(words).lstrip("-")
    if plain == name and 0 < len(name.encode()) <= LONGEST:
        return name
    mark = sha256(os.fsencode(name)).hexdigest()[:6]
    return f"{plain.encode()[: LONGEST - 7].decode(errors='ignore') or 'photo'}-{mark}"


def is_scene(name: str) -> bool:
    """Whether a scene may be called so."""
    return scene_of(Path(name)) == name


def suggest_scene(name: str) -> str:
    """The mend of a name that no scene may have."""
    return f"letters, digits, - and single _ inside, e.g. {scene_of(Path(name))}"


def scene_of_folder(folder: Path) -> str:
    """The name of the scene of an input folder: its own, or that of the folder around one that the workflow made."""
    folder = Path(os.path.normpath(folder.absolute()))  # a link is called as it is
    return scene_of(folder.parent if folder.name in MADE else folder)


def describe_missing(folder: Path) -> list[str]:
    """The files that an input folder lacks, in words."""
    if not folder.is_dir():
        return [f"no folder {folder}"]
    return [f"{folder} has no {name}" for name in INPUT_FILES if not (folder / name).is_file()]


def list_objects(folder: Path) -> dict[str, Mapping[str, bool]]:
    """Ids of the objects of an input folder, each with whether it has a door and a drawer; empty: not known.

    A file that breaks its contract is left to the stage that reads it.
    """
    try:
        items = json.loads(decode_file(folder / "annotations.json"))["objects"]
        panels: list[Mapping[str, bool]] = [{front: item.get(f"{front}s", 0) > 0 for front in FRONTS} for item in items]
        return dict(zip(object_ids(str(item["label"]) for item in items), panels, strict=True))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


class DepthNoiseConfig(Section):
    """Error that is added to perfect depth, so that it errs as estimated depth does."""

    range_constant: float = Field(USUAL_ERROR.a, ge=0, description="a of the range noise sigma(z) = a + b z^2, metres.")
    range_quadratic: float = Field(
        USUAL_ERROR.b, ge=0, description="b of the range noise, 1/metres: 1.7 cm in all at 3 m."
    )
    scale: float = Field(0.01, ge=0, description="Standard deviation of one factor on all depths of the picture.")


class ExtractionConfig(Section):
    """From pixels, depth and masks to objects in the floor frame."""

    source: str = Field(
        "folder",
        json_schema_extra={"kind": "sources"},
        description="Where depth, masks and captions come from. folder: from the files in the input folder.",
    )
    kwargs: dict[str, Any] = KWARGS
    depth_noise: Literal["model", "none"] = Field(
        "model",
        description="model: exact depth from the renderer is put through `noise` first. none: it is used as it is. "
        "Depth of your own pictures is never disturbed.",
    )
    noise: DepthNoiseConfig = Field(DepthNoiseConfig(), description="The noise model of `depth_noise: model`.")
    crop: float = Field(0.9, gt=0, le=1, description="Central part of the image that is used (paper: 0.9).")
    restore_border: bool = Field(
        True, description="Continue depth onto the border that was taken off, so that boxes keep their size."
    )
    max_tilt: float = Field(60.0, gt=0, lt=90, description="Largest angle between image-up and floor normal, degrees.")
    trim: float = Field(
        0.01,
        ge=0,
        lt=0.25,
        description="Share of the points left out at either end of a box (0: raw extremes).",
    )

    def list_unread(self) -> set[str]:
        """The noise model, if there is no noise."""
        return {"noise"} if self.depth_noise == "none" else set()
