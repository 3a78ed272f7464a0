"""What is known of scenes before anything runs: rooms by their recipes, input folders by their annotations."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

INPUT_FILES = ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json")
DOORS = {"bottom_cabinet", "wall_cabinet", "sideboard", "wardrobe", "fridge", "microwave", "oven", "dishwasher"}
DRAWERS = {"bottom_cabinet", "sideboard", "wardrobe", "chest_of_drawers", "fridge", "oven"}
Panels = Mapping[str, bool]


def rooms() -> list[str]:
    """Names of our rooms, in order."""
    from stages.scenes.rooms import ROOMS

    return [room.name for room in ROOMS]


def models_for(names: Sequence[str]) -> dict[str, int]:
    """Models per category that rooms need: no model stands in two of them."""
    from stages.scenes.rooms import BY_NAME

    return dict(Counter(item.category for name in names for item in BY_NAME[name].items))


def objects(scene: str, inputs: Mapping[str, str]) -> dict[str, Panels]:
    """Ids of the objects of a scene, each with whether it can have a door and a drawer; empty: not known."""
    if scene in inputs:
        return _of_folder(Path(inputs[scene]))
    if scene not in rooms():
        return {}
    from stages.scenes.rooms import BY_NAME

    items = BY_NAME[scene].items
    panels = (
        {
            "door": item.category in DOORS and item.want.doors[1] > 0,
            "drawer": item.category in DRAWERS and item.want.drawers[1] > 0,
        }
        for item in items
    )
    return dict(zip(_ids(item.label for item in items), panels, strict=True))


def missing(folder: Path) -> list[str]:
    """What an input folder lacks, in words."""
    if not folder.is_dir():
        return [f"no folder {folder}"]
    return [f"{folder} has no {name}" for name in INPUT_FILES if not (folder / name).is_file()]


def _ids(labels: Iterator[str]) -> Iterator[str]:
    """Ids as extraction gives them: `label_1`, `label_2`, ... (a test compares them)."""
    seen: Counter[str] = Counter()
    for label in labels:
        name = re.sub(r"[^a-z0-9]+", "_", label.lower()).strip("_") or "object"
        seen[name] += 1
        yield f"{name}_{seen[name]}"


def _of_folder(folder: Path) -> dict[str, Panels]:
    """The same of an input folder; a file that breaks its contract is left to the stage that reads it."""
    try:
        items = json.loads((folder / "annotations.json").read_text(encoding="utf-8"))["objects"]
        panels = [{"door": item.get("doors", 0) > 0, "drawer": item.get("drawers", 0) > 0} for item in items]
        return dict(zip(_ids(str(item["label"]) for item in items), panels, strict=True))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
