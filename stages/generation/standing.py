"""What stands in a generated scene, read from its file."""

from collections.abc import Mapping
from pathlib import Path

from stages.articulated.asset_folder import read_asset
from stages.contracts import GeneratedScene, InputError
from stages.contracts.objects import Mounting
from stages.generation.placed import Placed
from stages.geometry.boxes import UprightBox
from stages.procedural.resize import resized

STANDING = Mounting(type=2)  # for scenes that do not say


def placed_items(
    made: GeneratedScene, folders: Mapping[str, Path], cache: Path, path: Path
) -> tuple[list[Placed], dict[str, Path]]:
    """What stands in a scene, and by id the folders of the models at their sizes.

    Raises:
        InputError: nothing stands in it, or an asset is not in the library.
    """
    items, sized = [], {}
    for item in made.objects:
        if item.status != "ok":
            continue
        if item.asset not in folders:
            raise InputError(path, f"{item.id} is '{item.asset}', which the library does not have.")
        sized[item.id] = resized(folders[item.asset], item.size, cache)
        box = UprightBox(item.position, item.size, item.yaw)
        items.append(
            Placed(item.id, item.label, read_asset(sized[item.id]), box, item.mounting or STANDING, item.support)
        )
    if not items:
        raise InputError(path, "has no object that stands in it.")
    return items, sized
