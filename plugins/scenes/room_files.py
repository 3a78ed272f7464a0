"""Find and read the rooms, a YAML file each: the eight of Table 2, and a user's."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path

import yaml
from pydantic import ValidationError

from roomkin.plugins.scenes.recipe import RoomPlan
from roomkin.stages.config.categories import CATEGORIES, Known
from roomkin.stages.contracts.errors import InputError, fault_of, first_error, line_of
from roomkin.stages.contracts.files import read_text
from roomkin.stages.contracts.objects import object_ids
from roomkin.stages.contracts.parts import FRONTS
from roomkin.stages.plugins import data_file, list_available

Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # five times as fast where it is there


def series() -> list[Path]:
    """Files of the rooms of Table 2, in its order: no model stands in two of them."""
    return sorted(Path(__file__).with_name("rooms").glob("*.yaml"), key=lambda path: (len(path.stem), path.stem))


def room_files(own: Iterable[str] = (), packages: Sequence[str] = ()) -> dict[str, Path]:
    """Files of all rooms by their names: ours, those of the packages, and the files `own`.

    Raises:
        InputError: a file is not there, or a name is taken twice.
    """
    files = {path.stem: path for path in series()}
    files |= {name: data_file("rooms", module) for name, module in list_available("rooms", packages).items()}
    for path in map(Path, own):
        if not path.is_file():
            raise InputError("scenes.rooms", f"there is no file {path}.", "correct the path", code="E-ROOM-MISSING")
        if path.stem in files:
            fault = f"room '{path.stem}' is in {files[path.stem]} and in {path}."
            raise InputError("scenes.rooms", fault, "rename it", code="E-ROOM-NAME")
        files[path.stem] = path
    return files


def recipe_digest(path: Path | None) -> str:
    """Digest (12 hex digits) of what a room is made by: its own file and, of ours, those before it."""
    ours = series()
    used = ours[: ours.index(path) + 1] if path in ours else [path] if path else []
    return sha256(b"\0".join(file.read_bytes() for file in used)).hexdigest()[:12]


def read_room(path: Path) -> RoomPlan:
    """The room of a YAML file.

    Raises:
        InputError: it is no YAML, or no room; the field is named.
    """
    fix = "see docs/scenes.md"
    try:
        content = yaml.load(read_text(path, fix), Loader)
    except yaml.YAMLError as error:
        raise InputError(line_of(path, error), f"is no YAML: {fault_of(error)}.", fix, code="E-ROOM-FILE") from None
    if not isinstance(content, dict) or "name" in content:
        fault = "is no room: it needs keys like scale and items; its name is that of the file."
        raise InputError(path, fault, fix, code="E-ROOM-FILE")
    try:
        return RoomPlan.model_validate({"name": path.stem, **content})
    except ValidationError as error:
        raise InputError(path, f"is no room: {first_error(error)}.", fix, code="E-ROOM-FILE") from None


def count_models(files: Iterable[Path]) -> dict[str, int]:
    """Models per category that rooms need when no model stands in two of them."""
    return dict(Counter(item.category for path in files for item in read_room(path).items))


def list_objects(file: Path) -> dict[str, Mapping[str, bool]]:
    """Ids of the objects of a room, each with whether it can have a door and a drawer; empty: it cannot be read."""
    try:
        items = read_room(file).items
    except InputError:
        return {}
    known = ((item.model, CATEGORIES.get(item.category, Known(0, False, False))) for item in items)
    panels: Iterable[Mapping[str, bool]] = (
        {front: getattr(kind, f"{front}s") and getattr(model, f"{front}s")[1] > 0 for front in FRONTS}
        for model, kind in known
    )
    return dict(zip(object_ids(item.label for item in items), panels, strict=True))
