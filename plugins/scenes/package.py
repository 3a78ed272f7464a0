"""The package as the core knows it."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import Field

from roomkin.plugins.scenes.recipe import ScenesConfig, count_models, list_objects, room_files, series
from roomkin.stages.config.categories import CATEGORIES
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.packages import Package
from roomkin.stages.contracts.errors import InputError, suggest_nearest


def rooms_of(config: Any) -> Mapping[str, Callable[[], Mapping[str, Mapping[str, bool]]]]:
    """All rooms that could be asked for, each with what lists its objects."""
    files = room_files(config.experiment.room_files, config.implementations)
    return {name: partial(list_objects, path) for name, path in files.items()}


def find_mistakes(config: Any) -> Iterator[Mistake]:
    """Rooms that cannot be read, and models enough to furnish those that are asked for."""
    asked, assets, rooms = config.experiment.rooms, config.assets, [path.stem for path in series()]
    try:
        files = room_files(config.experiment.room_files, config.implementations)
    except InputError as error:
        yield Mistake.of(error, "experiment.room_files")
        return
    ours = [name for name in asked if name in rooms]
    if assets.own_only and assets.folders and ours:
        what = f"{ours[0]} is furnished with procedural models"
        yield Mistake("assets.own_only", what, "name pictures of yours in experiment.rooms, or leave own_only out")
    if assets.folders or assets.own_only:
        return  # what the user's folders hold is seen when they are read
    last = max((rooms.index(name) for name in ours), default=-1)
    furnished = {rooms[last]: [files[name] for name in rooms[: last + 1]]} if last >= 0 else {}
    furnished |= {name: [files[name]] for name in asked if name in files and name not in rooms}
    for room, used in furnished.items():
        yield from _lacking(room, used, assets.counts)


def _lacking(room: str, files: list[Path], counts: Mapping[str, int]) -> Iterator[Mistake]:
    """Categories of which the library would have too few models for these rooms, of which `room` is the last."""
    try:
        models = count_models(files)
    except InputError as error:
        yield Mistake("experiment.rooms", str(error), code=error.code)
        return
    for category, needed in models.items():
        if category not in CATEGORIES:
            what = f"{room} has an item of the category '{category}', which is not known"
            yield Mistake("experiment.rooms", what, suggest_nearest(category, CATEGORIES), "E-CONFIG-UNKNOWN")
        elif counts.get(category, 0) < needed:
            what = f"the rooms up to {room} need {needed}" if len(files) > 1 else f"{room} needs {needed}"
            yield Mistake(f"assets.counts.{category}", what, f"raise it, or leave {room} out of experiment.rooms")


PACKAGE = Package(
    commands={"render": ScenesConfig}, section="scenes", rooms=rooms_of, mistakes=find_mistakes,
    sections={"scenes": (ScenesConfig, Field(ScenesConfig(), description="The sim-to-sim rooms (B.1, Table 2)."))},
    outside=lambda config: config.experiment.room_files,
)  # fmt: skip
