"""Pictures of the user's: input folders by the names of their scenes."""

import json
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, Field, model_validator

from stages.config.mistakes import Mistake
from stages.contracts.objects import object_ids
from stages.contracts.parts import FRONTS
from stages.contracts.section import Section

NAME = re.compile(r"[A-Za-z0-9-]+(_[A-Za-z0-9-]+)*")  # becomes part of paths
INPUT_FILES = ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json")
MADE = ("input", "frame")  # what input folders are called that the workflow makes in a folder of the scene's name
HOLDS = "docs/scenes.md says what an input folder holds"


class Input(Section):
    """An input folder. Its further keys are those of the package `inputs`, which makes folders of pictures."""

    model_config = ConfigDict(extra="allow")

    folder: str = Field("", description="an input folder (docs/scenes.md), in the place of all else")

    @model_validator(mode="before")
    @classmethod
    def _of_text(cls, given: Any) -> Any:
        """A text alone names a folder."""
        return {"folder": given} if isinstance(given, str) else given

    @property
    def alone(self) -> bool:
        """Whether it is a picture without depth, for networks."""
        return False

    def place(self, scene: str) -> str:
        """The input folder of a scene."""
        return self.folder

    def files(self) -> dict[str, str]:
        """The user's files and folders by their keys."""
        return {"folder": self.folder} if self.folder else {}

    def mistakes(self, key: str) -> Iterator[Mistake]:
        """Its mistakes; `key`: where it stands in the config."""
        for what in describe_missing(Path(self.folder)) if self.folder else ():
            yield Mistake(key, what, HOLDS, "E-CONFIG-FILE")


def scene_of(path: Path) -> str:
    """The name of the scene in a folder: letters, digits, - and single _ inside."""
    return "_".join(re.findall(r"[A-Za-z0-9-]+", path.name)).lstrip("-") or "photo"


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
        items = json.loads((folder / "annotations.json").read_text(encoding="utf-8"))["objects"]
        panels: list[Mapping[str, bool]] = [{front: item.get(f"{front}s", 0) > 0 for front in FRONTS} for item in items]
        return dict(zip(object_ids(str(item["label"]) for item in items), panels, strict=True))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
