"""Our own scene_<rank>.json; beside it objects.json, if it was made of masks that were given."""

from pathlib import Path

import numpy as np

from roomkin.plugins.scorecard.readers.solid import make_scene
from roomkin.plugins.scorecard.truth import About, RoomScene
from roomkin.stages.contracts import GeneratedScene, Objects, read_json


def read(path: Path, about: About) -> RoomScene:
    """The things that are placed, by their categories, in the floor frame.

    Raises:
        InputError: it breaks its contract.
    """
    scene = read_json(GeneratedScene, path)
    told = {"drawn masks", "exact masks"} & {*about.given}
    beside = path.with_name("objects.json")
    seen = read_json(Objects, beside).objects if told and beside.is_file() else []
    numbers = {item.id: item.mask for item in seen}
    items = [item for item in scene.objects if item.status == "ok"]
    places = {item.id: str(place) for place, item in enumerate(items)} | {"floor": "floor", "wall": "wall"}
    things = [
        {"name": item.category, "center": item.position, "size": item.size, "yaw": item.yaw}
        | {"number": numbers.get(item.id), "support": places.get(item.support)}
        for item in items
    ]
    return make_scene(things, np.array(scene.floor_from_camera), about)
