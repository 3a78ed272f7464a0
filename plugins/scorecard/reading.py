"""Read a submission: one JSON, or a folder with method.json and a file or folder per room. What cannot be read of a
room is told, and that room counts as missed."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from roomkin.plugins.scorecard.readers import acdc, generated, glb, mjcf, plain
from roomkin.plugins.scorecard.truth import About, RoomScene, Submission, SubmissionFile
from roomkin.stages.contracts.errors import InputError, explain, file_missing
from roomkin.stages.contracts.files import first_error, read_json, read_text

HEAD = "method.json"
INSIDE = ("scene.json", "scene_1.json", "scene.glb", "scene.xml", "scene.usdc", "scene.usda", "scene.usd",
          "scene_0_info.json", "step_3_output/scene_0/scene_0_info.json")  # fmt: skip
TEMPLATE = "see docs/results/scorecard.md"


def _read_usd(path: Path, about: About) -> RoomScene:
    from roomkin.plugins.scorecard.readers import usd  # half a second, and a package that others may lack

    return usd.read(path, about)


READERS: Mapping[str, Callable[[Path, About], RoomScene]] = {
    ".glb": glb.read, ".xml": mjcf.read, ".usd": _read_usd, ".usda": _read_usd, ".usdc": _read_usd,
}  # fmt: skip


def read_submission(path: Path, rooms: Iterable[str]) -> Submission:
    """A submission, as far as it can be read.

    Args:
        path: a JSON file, or a folder: method.json, and by the name of each room ROOM.json, ROOM.glb, ROOM.xml (MuJoCo)
            or ROOM.usdc, or a folder of that name with scene.json, scene.glb, ... or what the authors' code writes.
        rooms: names of the rooms of the set; others are left.

    Raises:
        InputError: there is no such file, or its head does not say what must be said.
    """
    if path.is_dir():
        about = read_json(About, path / HEAD, f"write it: {TEMPLATE}")
        found = {room: file for room in rooms if (file := find_room(path, room))}
        return _collect(about, found, lambda file: read_room(file, about))
    if not path.is_file():
        raise file_missing(path, TEMPLATE)
    whole = read_json(SubmissionFile, path, TEMPLATE)
    about = About(**{name: getattr(whole, name) for name in About.model_fields})
    given = {room: whole.rooms[room] for room in rooms if room in whole.rooms}
    return _collect(about, given, lambda document: plain.read(document, path.parent))


def _collect(about: About, sources: Mapping[str, Any], read: Callable[[Any], RoomScene]) -> Submission:
    scenes, unread = dict[str, RoomScene](), dict[str, str]()
    for room, source in sources.items():
        try:
            scene = read(source)
            scenes[room] = scene if {"drawn masks", "exact masks"} & {*about.given} else forget_numbers(scene)
        except InputError as error:
            unread[room] = str(error)
        except ValidationError as error:
            unread[room] = first_error(error)
        except Exception as error:  # a library's reader, on a file from elsewhere: whatever it raises is that room's
            unread[room] = explain(error)
    return Submission(about, scenes, unread)


def forget_numbers(scene: RoomScene) -> RoomScene:
    """The scene without the numbers of masks: who was given none cannot know them."""
    things = [thing.model_copy(update={"number": None}) for thing in scene.room.things]
    return replace(scene, room=scene.room.model_copy(update={"things": things}))


def find_room(folder: Path, room: str) -> Path | None:
    """The file of a room in a submission's folder; None: it has none."""
    named = [folder / f"{room}{suffix}" for suffix in (".json", *READERS)]
    inside = [folder / room / name for name in INSIDE]
    other = [path for path in sorted(folder.glob(f"{room}.*")) if path.is_file()]
    return next((path for path in [*named, *inside, *other] if path.is_file()), None)


def read_room(path: Path, about: About) -> RoomScene:
    """The scene of a room, by its format.

    Raises:
        InputError: no reader knows its format, or it is broken.
        ValidationError: it is JSON, and does not say what it must.
    """
    if path.suffix in READERS:
        return READERS[path.suffix](path, about)
    if path.suffix != ".json":
        known = ", ".join(["JSON", *(suffix[1:].upper() for suffix in READERS)])
        raise InputError(path.name, "has a format that is not read.", f"one of {known}", code="E-FORMAT")
    try:
        document = json.loads(read_text(path))
    except ValueError as error:
        raise InputError(path.name, f"is no JSON: {error}.", code="E-FORMAT") from None
    if isinstance(document, dict) and "cam_pose" in document:
        return acdc.read(document)
    if isinstance(document, dict) and {"floor_from_camera", "objects"} <= document.keys():
        return generated.read(path, about)
    return plain.read(document, path.parent)
