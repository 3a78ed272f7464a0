"""Read a generated scene as the room of a task about one of its objects."""

from collections.abc import Mapping
from pathlib import Path

from stages.articulated.asset_folder import read_asset
from stages.articulated.resizing import resize_asset
from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from stages.contracts.generated import GeneratedScene, PlacedObject
from stages.contracts.library_folder import AssetFolders
from stages.geometry.boxes import UprightBox
from stages.simulation.room import Furniture, Room

AGAIN = "generate the scenes again"


def read_room(path: Path, target: str, library: Path, cache: Path) -> Room:
    """The room of a generated scene about one of its objects.

    Args:
        cache: folder for models at their sizes.

    Raises:
        InputError: the scene has no such object, or a model that the library does not have.
    """
    generated = read_json(GeneratedScene, path, AGAIN)
    folders = AssetFolders(library)
    placed = {item.id: item for item in generated.objects if item.status == "ok"}
    if target not in placed:
        failed = {item.id: item.reason for item in generated.objects if item.status == "failed"}
        why = f"object '{target}' failed: {failed[target]}" if target in failed else f"has no object '{target}'"
        raise InputError(path, f"{why}.", f"those that stand: {', '.join(placed) or 'none'}", code="E-OBJECT-MISSING")
    items = {name: _furniture(item, folders, cache, path) for name, item in placed.items()}
    return Room(generated, items.pop(target), list(items.values()))


def _furniture(item: PlacedObject, folders: Mapping[str, Path], cache: Path, path: Path) -> Furniture:
    if item.asset not in folders:
        what = f"{item.id} is '{item.asset}', which the library does not have."
        raise InputError(path, what, AGAIN, code="E-LIBRARY-ASSET")
    folder = resize_asset(folders[item.asset], item.size, cache)
    return Furniture(item.id, folder, read_asset(folder), UprightBox(item.position, item.size, item.yaw))
