"""Import some models of a user's folder: one folder per model and an index of them."""

import shutil
from pathlib import Path

from stages.assets.discover import discover
from stages.assets.imports import by_suffix, import_models
from stages.config.assets import OwnOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_options, write_json
from stages.contracts.library import LibraryEntry, LibraryPart


def run(*, folder: Path, models: tuple[str, ...], out: Path, options: str = "{}") -> None:
    """Write the index and, in the folder of its name, <id>/ for every model; what cannot be used is left out.

    Args:
        folder: of the user.
        models: <id>=<file> each, files below `folder`.
        out: path of the index.
        options: JSON of the config section `assets`.
    """
    kinds = by_suffix(read_options(OwnOptions, options).importers)
    names = {Path(file): name for name, _, file in (model.partition("=") for model in models)}
    wanted = {names[one.path]: one for one in discover(folder, list(kinds)) if one.path in names}
    if gone := set(names.values()) - set(wanted):
        raise InputError(folder, f"holds no model of '{min(gone)}'.", "each of --models is <id>=<file>")
    place = out.with_suffix("")
    shutil.rmtree(place, ignore_errors=True)
    assets, left_out = import_models(wanted, kinds, place)
    entries = [LibraryEntry.of(asset, f"{place.name}/{asset.id}") for asset in assets]
    write_json(out, LibraryPart(assets=sorted(entries, key=lambda entry: entry.id), left_out=left_out))
