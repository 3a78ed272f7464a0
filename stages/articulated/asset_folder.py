"""Asset folders: read their `asset.json`, write one whole or not at all, and the checksum that all of them carry."""

import hashlib
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stages.contracts.files import read_json
from stages.contracts.library import Asset


def read_asset(folder: Path) -> Asset:
    """The `asset.json` of an asset folder."""
    return read_json(Asset, Path(folder) / "asset.json", "make the library again: python -m stages.assets library")


def checksum(folder: Path) -> str:
    """sha256 over the names and bytes of all files of the folder but asset.json, in order of name."""
    digest = hashlib.sha256()
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != "asset.json")
    for path in files:
        content = path.read_bytes()
        digest.update(f"{path.relative_to(folder).as_posix()}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


@contextmanager
def atomic_folder(out: Path) -> Iterator[Path]:
    """A temporary folder that takes the place of `out` only if the block succeeds."""
    out = Path(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    folder = out.with_name(f".partial-{out.name}")  # the same at every try: what a killed process left goes
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    try:
        yield folder
        if out.exists():
            shutil.rmtree(out)
        folder.replace(out)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
