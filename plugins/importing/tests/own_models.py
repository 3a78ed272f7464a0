"""A user's folder, imported by itself."""

from collections.abc import Sequence
from pathlib import Path

from roomkin.plugins.importing.imports import (
    IMPORTERS,
    Given,
    by_suffix,
    import_file,
    import_models,
    named_models,
    with_notes,
)
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.library import Asset


def import_folder(folder: Path, models: Path, taken: Sequence[str] = ()) -> list[Asset]:
    """The models of a folder as assets below `models`; if none can be used, the reason of the first is raised."""
    kinds = by_suffix(IMPORTERS)
    assets, left_out = import_models(named_models([folder], kinds, taken), kinds, models)
    if not assets:
        raise InputError(folder, left_out[0], code="E-ASSET-MISSING")
    return assets


def import_model(path: Path, folder: Path, models: Path) -> Asset:
    """One model file of a folder as an asset below `models`."""
    found = Given(path, folder, path.relative_to(folder).parts[0], path.stem)
    return import_file(with_notes(found, by_suffix(IMPORTERS)[path.suffix.lower()]), models)[0]
