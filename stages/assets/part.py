"""Command `part`: the index of a shard that is a part of a library, as the shard's name says."""

from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, write_json
from roomkin.stages.contracts.library import Library
from roomkin.stages.contracts.library_folder import holds


def run(*, library: Path, shard: str, out: Path) -> None:
    """Write an index of the models of some categories, which stay in the library's archives.

    Args:
        library: library.json of the assets stage.
        shard: name of the part, from shards.json of the matching stage.
        out: the index, in the same folder.

    Raises:
        InputError: the library has none of them.
    """
    whole = read_json(Library, library)
    models = [entry for entry in whole.assets if holds(shard, entry)]
    if not models:
        raise InputError(library, f"has no model of {shard}.", "make shards.json again", code="E-LIBRARY-EMPTY")
    write_json(out, Library(assets=models))
