"""Our own reconstructions as submissions for the scorecard (docs/results/scorecard.md)."""

import json
from pathlib import Path
from typing import Any

from benchmarks.open_rooms import pictures
from roomkin.stages.contracts import GeneratedScene, Objects, read_json, write_text
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.library_folder import AssetFolders

GIVEN = {
    "exact": ["depth", "exact masks", "names", "panels"],
    "drawn": ["depth", "drawn masks", "names", "panels"],
    "corrected": ["depth", "clicks", "names", "panels"],
    "unaided": ["depth"],
    "alone": [],
}
TITLE = {
    "exact": "roomkin, told exact outlines and names", "drawn": "roomkin, told drawn outlines and names",
    "corrected": "roomkin, corrected by clicks", "unaided": "roomkin, no hand", "alone": "roomkin, the picture alone",
}  # fmt: skip
SEEN = "chosen on `work`; the other sets were looked at as docs/results/open.md says; no model of these rooms"


def submit(root: Path, results: Path, half: str, masks: str, out: Path, version: str) -> None:
    """Write a submission of the scenes of first cousins of a set.

    Args:
        root: folder of `render` and `run`.
        results: folder with the library.
        half: the set.
        masks: of `pictures.MASKS`, what was given.
        out: the file.
        version: commit of the code that `run` ran.
    """
    folders = AssetFolders(results / "assets/library/library.json")
    rooms = {}
    for folder in pictures.folders(root, half):
        made = root / "results" / masks / folder.name
        if (made / "geometry/scene_1.json").is_file():
            rooms[folder.name] = describe_scene(made, masks, folders)
    note = f"{len(rooms)} of {len(pictures.folders(root, half))} rooms were run."
    about = {
        "version": 1, "method": TITLE[masks], "given": GIVEN[masks], "code": f"this repository at {version}",
        "by": "this project", "seen": SEEN, "note": note,
    }  # fmt: skip
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(room)}" for name, room in rooms.items())
    write_text(out, json.dumps(about, indent=1)[:-2] + f',\n "rooms": {{\n{lines}\n}}}}\n')
    print(f"{out}: {len(rooms)} rooms")


def describe_scene(made: Path, masks: str, folders: AssetFolders) -> dict[str, Any]:
    """A room of a submission from a reconstruction's folder."""
    scene = read_json(GeneratedScene, made / "geometry/scene_1.json")
    numbers = {item.id: item.mask for item in read_json(Objects, made / "extraction/objects.json").objects}
    items = [item for item in scene.objects if item.status == "ok"]
    places = {item.id: str(place) for place, item in enumerate(items)} | {"floor": "floor", "wall": "wall"}
    things = [
        describe_item(item, folders)
        | ({"number": numbers[item.id]} if masks in pictures.BY_HAND else {})
        | ({"support": places[item.support]} if item.support in places else {})
        for item in items
    ]
    frame = {"frame": "floor", "floor_from_camera": scene.floor_from_camera}
    return frame | {"scale": "free" if masks == pictures.ALONE else "metric", "things": things}


def describe_item(item: PlacedObject, folders: AssetFolders) -> dict[str, Any]:
    """A thing of a submission, with how the model in its place opens."""
    opens = [joint.panel.hinge for joint in folders.asset(item.asset).joints if joint.panel is not None]
    said: dict[str, Any] = {
        "name": item.category,
        "center": [round(value, 4) for value in item.position],
        "size": [round(value, 4) for value in item.size],
        "yaw": round(item.yaw, 4),
    }
    return said | ({"opens": opens} if opens else {})
