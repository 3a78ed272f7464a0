"""Make the library: one folder per model and an index of them (paper A.1)."""

from pathlib import Path

from stages.cli import progress
from stages.config.assets import LibraryOptions
from stages.contracts.errors import InputError
from stages.contracts.files import read_options, write_json
from stages.contracts.library import Asset, Library, LibraryEntry
from stages.procedural.catalogue import CATEGORIES, model_name, sample
from stages.procedural.folder import build


def run(*, out: Path, options: str = "{}", seed: int = 0) -> None:
    """Write library.json and, beside it, models/<id>/ for every model.

    Args:
        out: path of library.json.
        options: JSON of the config section `assets`.
        seed: of the procedural models.
    """
    config = read_options(LibraryOptions, options)
    unknown = sorted(set(config.counts) - set(CATEGORIES))
    if unknown:
        raise InputError("assets.counts", f"no category '{unknown[0]}'.", f"one of {', '.join(CATEGORIES)}")
    folder = out.parent / "models"
    wanted = [(category, k) for category, count in sorted(config.counts.items()) for k in range(count)]
    assets = [make(category, k, seed, folder) for category, k in progress(wanted, "models", len(wanted))]
    if config.folders:
        from stages.assets.imports import import_folders

        assets += import_folders(
            [Path(path) for path in config.folders], folder, [asset.id for asset in assets], config.importers
        )
    if not assets:
        raise InputError("assets", "the library would be empty.", "set assets.counts or assets.folders")
    write_json(out, index_of(assets))


def make(category: str, index: int, seed: int, folder: Path) -> Asset:
    """Build the `index`-th procedural model of a category."""
    recipe = sample(category, index, seed)
    name = model_name(category, index)
    provenance = f"procedural: {recipe.generator}, seed {seed}"
    return build(recipe, None, folder / name, name, category, provenance)


def index_of(assets: list[Asset]) -> Library:
    """The index, sorted by id."""
    ids = [asset.id for asset in assets]
    double = sorted(name for name in set(ids) if ids.count(name) > 1)
    if double:
        raise InputError("assets.folders", f"two models are called '{double[0]}'.", "rename one")
    entries = [
        LibraryEntry(
            id=asset.id,
            category=asset.category,
            folder=f"models/{asset.id}",
            doors=asset.doors,
            drawers=asset.drawers,
            size=asset.size,
            placement=asset.placement,
            checksum=asset.checksum,
        )
        for asset in sorted(assets, key=lambda asset: asset.id)
    ]
    return Library(assets=entries)
