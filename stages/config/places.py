"""What is known of scenes before anything runs: rooms by their recipes, input folders by their annotations."""

import json
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

from stages.config.categories import CATEGORIES, Known
from stages.config.inputs import Input
from stages.config.room_files import read_room, series
from stages.contracts.errors import InputError
from stages.contracts.objects import object_ids

Panels = Mapping[str, bool]


def rooms() -> list[str]:
    """Names of our rooms, in order."""
    return [path.stem for path in series()]


def models_for(files: Iterable[Path]) -> dict[str, int]:
    """Models per category that rooms need when no model stands in two of them."""
    return dict(Counter(item.category for path in files for item in read_room(path).items))


def objects(scene: str, inputs: Mapping[str, Input], files: Mapping[str, Path]) -> dict[str, Panels]:
    """Ids of the objects of a scene, each with whether it can have a door and a drawer; empty: not known."""
    if scene in inputs:
        return _of_folder(Path(inputs[scene].place(scene)))
    try:
        items = read_room(files[scene]).items
    except (KeyError, InputError):
        return {}
    known = ((item.model, CATEGORIES.get(item.category, Known(0, False, False))) for item in items)
    panels = (
        {"door": kind.doors and model.doors[1] > 0, "drawer": kind.drawers and model.drawers[1] > 0}
        for model, kind in known
    )
    return dict(zip(object_ids(item.label for item in items), panels, strict=True))


def _of_folder(folder: Path) -> dict[str, Panels]:
    """The same of an input folder; a file that breaks its contract is left to the stage that reads it."""
    try:
        items = json.loads((folder / "annotations.json").read_text(encoding="utf-8"))["objects"]
        panels = [{"door": item.get("doors", 0) > 0, "drawer": item.get("drawers", 0) > 0} for item in items]
        return dict(zip(object_ids(str(item["label"]) for item in items), panels, strict=True))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
