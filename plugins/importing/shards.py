"""The user's models in shards, and the files that each depends on: a change makes anew what it touches, no more."""

from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from roomkin.plugins.importing.discover import NUMBERED, PACK, PAGE, is_utf8
from roomkin.plugins.importing.imports import by_suffix, named_models
from roomkin.plugins.importing.sandbox import is_inside
from roomkin.stages.config.assets import AssetsConfig
from roomkin.stages.config.code import files_digest
from roomkin.stages.contracts.files import MAX_TEXT
from roomkin.stages.contracts.library import model_name

MEAN = 8  # models per shard: few enough to make them anew for one of them, enough to pay for Python's start
TEXT = {".urdf", ".xml", ".gltf", ".dae", ".obj", ".mtl"}
ROAMING = (b"../", b'".."', b"package://", b"$(find", b"<include")  # in them: they may name files of other models


class Shard(NamedTuple):
    """Some models of a user's folder by name, and all files that they may read."""

    folder: Path
    models: dict[str, Path]
    files: list[Path]

    def digest(self) -> str:
        """Of names and bytes of the files: one that was merely touched is the same."""
        return files_digest(str(path) for path in self.files)

    def place(self, first: object) -> str:
        """The user's folder, or its place among a storage's local copies, where the first of `files` is `first`."""
        return str(first).removesuffix(str(self.files[0].relative_to(self.folder))).rstrip("/")

    def list_files(self, place: str) -> list[str]:
        """<id>=<file> of each model, below that place."""
        return [f"{name}={Path(place, file.relative_to(self.folder))}" for name, file in self.models.items()]


def own_shards(config: AssetsConfig) -> dict[str, Shard]:
    """The shards of the user's folders by name.

    The models of a folder are ordered by the digests of their names, and one digest in `MEAN` begins a shard: a new
    model joins one shard, or cuts it in two; the others stay as they are.

    Raises:
        InputError: a folder is missing or empty.
    """
    taken = [model_name(category, k) for category, count in config.counts.items() for k in range(count)]
    models = named_models([Path(folder) for folder in config.folders], by_suffix(config.importers), taken)
    shards: dict[str, Shard] = {}
    for folder in dict.fromkeys(found.folder for found in models.values()):
        inside = {name: found.path for name, found in models.items() if found.folder == folder}
        read = files_of(folder, list(inside.values()))
        for group in groups(list(inside)):
            files = sorted({file for name in group for file in read[inside[name]]})
            first = sha256(group[0].encode()).hexdigest()
            shards[f"own_{first[:12]}"] = Shard(folder, {name: inside[name] for name in group}, files)
    return shards


def groups(names: Sequence[str]) -> list[list[str]]:
    """The names that share a shard, `MEAN` on average."""
    cut: list[list[str]] = []
    for digest, name in sorted((sha256(name.encode()).digest(), name) for name in names):
        if not cut or digest[-1] % MEAN == 0:
            cut.append([])
        cut[-1].append(name)
    return cut


def files_of(folder: Path, models: Sequence[Path]) -> dict[Path, list[Path]]:
    """The files that each model of a folder may read: those of its own place, and those that lie in no model's place.

    Its place is <category>/<model>/, <number>/, or the file alone. A model that names other folders may read all files.
    """
    unread = {folder / PAGE, folder / PACK}
    every = [path for path in folder.rglob("*") if is_utf8(str(path)) and is_inside(path, folder)]
    every = [path for path in every if path not in unread]
    places = {_place(model, folder) for model in models}
    lying: dict[Path | None, list[Path]] = {}
    for path in every:
        parts = path.relative_to(folder).parts
        above = (folder.joinpath(*parts[:depth]) for depth in (1, 2))
        lying.setdefault(next((place for place in above if place in places), None), []).append(path)
    read = {}
    for model in models:
        own = lying.get(_place(model, folder), [])
        read[model] = every if any(map(_may_name_others, own)) else own + lying.get(None, [])
    return read


def _place(model: Path, folder: Path) -> Path:
    parts = model.relative_to(folder).parts
    numbered = len(parts) == 2 and parts[1] in NUMBERED
    return folder.joinpath(*parts[: 1 if numbered else 2])


def _may_name_others(file: Path) -> bool:
    """Whether it may name files of other models, or is too large to tell."""
    if file.suffix.lower() not in TEXT:
        return False
    return file.stat().st_size > MAX_TEXT or any(mark in file.read_bytes() for mark in ROAMING)
