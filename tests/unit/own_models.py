"""A user's folder, imported by itself."""

from collections.abc import Sequence
from pathlib import Path

from stages.assets.imports import IMPORTERS, by_suffix, import_models, named_models
from stages.contracts.errors import InputError
from stages.contracts.library import Asset


def import_folder(folder: Path, models: Path, taken: Sequence[str] = ()) -> list[Asset]:
    """The models of a folder as assets below `models`; if none can be used, the reason of the first is raised."""
    kinds = by_suffix(IMPORTERS)
    assets, left_out = import_models(named_models([folder], kinds, taken), kinds, models)
    if not assets:
        raise InputError(folder, left_out[0])
    return assets
