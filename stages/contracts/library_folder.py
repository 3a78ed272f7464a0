"""The library of models on disk: an index beside zip archives with a folder per model, in parts that are joined."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache, partial
from hashlib import sha256
from pathlib import Path

from pydantic import Field, model_validator

from roomkin.stages.contracts.archives import open_archive, pack, unpack
from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.files import MAX_TEXT, Document, parse_json, read_json, write_json
from roomkin.stages.contracts.library import Asset, LibraryEntry, LibraryPart
from roomkin.stages.contracts.types import Text, check_unique

PART = "part_"
DIGITS = 4  # of a category's code: two of 60 categories share one with 1 chance in 40, and then both are drawn


class SceneShards(Document):
    """`shards.json`: the shards that hold all that the objects of a picture may be compared with."""

    shards: list[Text] = Field(min_length=1, description="as in `shard_<name>.json`; a part is named by its categories")

    @model_validator(mode="after")
    def _check_names(self) -> "SceneShards":
        check_unique("shards", self.shards)
        return self


def name_part(categories: Iterable[str]) -> str:
    """The shard of all models of some categories: a name that says which, whatever else the library holds."""
    return PART + "".join(sorted({_code(category) for category in categories}))


def holds(shard: str, model: LibraryEntry) -> bool:
    """Whether a shard holds a model of the library."""
    if not shard.startswith(PART):
        return Path(model.archive).stem == f"shard_{shard}"
    codes = shard.removeprefix(PART)
    return _code(model.category) in {codes[at : at + DIGITS] for at in range(0, len(codes), DIGITS)}


def _code(category: str) -> str:
    return sha256(category.encode()).hexdigest()[:DIGITS]


AGAIN = "make it again: snakemake --cores 2 library"
FIRST = "make it first: snakemake --cores 2 library"
changed = partial(InputError, fix=AGAIN, code="E-ASSET-CHANGED")
incomplete = partial(InputError, fix=AGAIN, code="E-ASSET-MISSING")


def write_part(out: Path, folder: Path, left_out: Iterable[str] = ()) -> None:
    """Write the index `out` of the asset folders in `folder`, and beside it the archive that they are packed into."""
    archive = out.with_suffix(".zip")
    assets = sorted((read_json(Asset, path) for path in folder.glob("*/asset.json")), key=lambda asset: asset.id)
    pack(folder, archive)
    entries = [LibraryEntry.of(asset, archive.name) for asset in assets]
    write_json(out, LibraryPart(assets=entries, left_out=list(left_out)))


class AssetFolders(Mapping[str, Path]):
    """The models of a library, or of parts of one, as folders by id, in order of id.

    A model is unpacked when its folder is asked for; the folder lasts as long as the process. `categories`: what is
    known of them, by name.

    Raises:
        InputError: an index cannot be read; when a model is asked for: there is none of that id, or its archive does
            not hold what the index says.
    """

    def __init__(self, *indices: Path) -> None:
        parts = {path: read_json(LibraryPart, path, FIRST) for path in indices}
        listed = [(path.parent, entry) for path, part in parts.items() for entry in part.assets]
        found = {entry.id: (folder / entry.archive, entry.checksum) for folder, entry in listed}
        self._indices, self._entries = ", ".join(map(str, indices)), dict(sorted(found.items()))
        self.categories = {row.name: row for part in parts.values() for row in part.categories}

    def __getitem__(self, asset: str) -> Path:
        if asset not in self._entries:
            what = f"has no asset '{asset}'."
            raise InputError(self._indices, what, suggest_nearest(asset, self._entries), code="E-LIBRARY-ASSET")
        return _unpack_asset(*self._entries[asset], asset)

    def __contains__(self, asset: object) -> bool:
        return asset in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def asset(self, asset: str) -> Asset:
        """The asset.json of a model, for which nothing is unpacked."""
        return _asset(*self._entries[asset], asset)

    def archive(self, asset: str) -> Path:
        """The archive of a model."""
        return self._entries[asset][0]


def _asset(path: Path, checksum: str, asset: str) -> Asset:
    where, name = path / asset / "asset.json", f"{asset}/asset.json"
    with open_archive(path, AGAIN) as archive:
        if name not in archive.NameToInfo:
            raise incomplete(path, f"holds no {name}.")
        if archive.getinfo(name).file_size > MAX_TEXT:
            raise InputError(where, f"is larger than {MAX_TEXT // 10**6} MB.", AGAIN, code="E-FILE-LARGE")
        content = archive.read(name)
    found = parse_json(Asset, content.decode("utf-8-sig", errors="replace"), where, AGAIN)
    if found.checksum != checksum:
        raise changed(where, f"checksum: is {found.checksum!r}, the index says {checksum!r} of '{asset}'.")
    return found


@cache
def _unpack_asset(path: Path, checksum: str, asset: str) -> Path:
    """Cached by checksum, too: another model of the same name has a folder of its own."""
    _asset(path, checksum, asset)
    return unpack(path, AGAIN, f"{asset}/") / asset


def check_asset(path: Path) -> Asset:
    """asset.json of an asset folder, and that the URDF which it names is there."""
    asset = read_json(Asset, path, AGAIN)
    if not (path.parent / asset.urdf).is_file():
        raise incomplete(path, f"urdf: there is no {asset.urdf} beside it.")
    return asset


def check_models(path: Path) -> None:
    """An index and every model of its archives: what the index says of one is what its asset.json says."""
    folders = AssetFolders(path)
    for entry in read_json(LibraryPart, path, AGAIN).assets:
        asset, archive = folders.asset(entry.id), path.parent / entry.archive
        for name in ("id", "category", "doors", "drawers"):
            found, listed = getattr(asset, name), getattr(entry, name)
            if found != listed:
                what = f"{name}: is {found!r}, {path.name} says {listed!r} of '{entry.id}'."
                raise changed(archive / entry.id / "asset.json", what)
        with open_archive(archive, AGAIN) as opened:
            if f"{entry.id}/{asset.urdf}" not in opened.NameToInfo:
                raise incomplete(archive / entry.id, f"urdf: there is no {asset.urdf} beside it.")
