"""Make the procedural models: one folder per model and an index of them (paper A.1)."""

from pathlib import Path

from stages.cli import progress
from stages.config.assets import LibraryOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_options, write_json
from stages.contracts.library import Asset, Library, LibraryEntry
from stages.procedural.catalogue import CATEGORIES, model_name, sample
from stages.procedural.folder import build


def run(*, out: Path, options: str = "{}", seed: int = 0) -> None:
    """Write the index and, beside it, models/<id>/ for every model.

    Args:
        out: path of the index, a library.json.
        options: JSON of the config section `assets`.
        seed: of the models.
    """
    config = read_options(LibraryOptions, options)
    unknown = sorted(set(config.counts) - set(CATEGORIES))
    if unknown:
        raise InputError("assets.counts", f"no category '{unknown[0]}'.", f"one of {', '.join(CATEGORIES)}")
    wanted = [(category, k) for category, count in sorted(config.counts.items()) for k in range(count)]
    if not wanted:
        raise InputError("assets", "the library would be empty.", "set assets.counts or assets.folders")
    folder = out.parent / "models"
    assets = [make(category, k, seed, folder) for category, k in progress(wanted, "models", len(wanted))]
    write_json(
        out,
        Library(
            assets=sorted(
                (LibraryEntry.of(asset, f"models/{asset.id}") for asset in assets), key=lambda entry: entry.id
            )
        ),
    )


def make(category: str, index: int, seed: int, folder: Path) -> Asset:
    """Build the `index`-th procedural model of a category."""
    recipe = sample(category, index, seed)
    name = model_name(category, index)
    provenance = f"procedural: {recipe.generator}, seed {seed}"
    return build(recipe, None, folder / name, name, category, provenance)
