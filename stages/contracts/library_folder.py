"""A library on disk: library.json and the asset folders that it names."""

from pathlib import Path

from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from stages.contracts.library import Asset, Library, LibraryPart

AGAIN = "make it again: python -m stages.assets library"


def check_asset(path: Path) -> Asset:
    """asset.json, and that the URDF which it names is there."""
    asset = read_json(Asset, path, AGAIN)
    if not (path.parent / asset.urdf).is_file():
        raise InputError(path, f"urdf: there is no {asset.urdf} beside it.", AGAIN)
    return asset


def check_library(path: Path) -> None:
    """library.json and every asset: what the index says of one is what its asset.json says."""
    _check_assets(path, read_json(Library, path, AGAIN))


def check_part(path: Path) -> None:
    """The same for a part of a library, which may be empty."""
    _check_assets(path, read_json(LibraryPart, path, AGAIN))


def _check_assets(path: Path, library: LibraryPart) -> None:
    for entry in library.assets:
        file = path.parent / entry.folder / "asset.json"
        asset = check_asset(file)
        for name in ("id", "category", "doors", "drawers", "checksum"):
            found, said = getattr(asset, name), getattr(entry, name)
            if found != said:
                raise InputError(file, f"{name}: is {found!r}, {path.name} says {said!r} of '{entry.id}'.", AGAIN)
