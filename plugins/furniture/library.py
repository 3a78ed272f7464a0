"""Make the procedural models: an archive of them and its index (paper A.1)."""

from pathlib import Path
from tempfile import TemporaryDirectory

from roomkin.plugins.furniture.catalogue import ALL, sample
from roomkin.plugins.furniture.folder import build
from roomkin.stages.cli import progress
from roomkin.stages.config.assets import LibraryOptions
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_options
from roomkin.stages.contracts.library import Asset, model_name
from roomkin.stages.contracts.library_folder import write_part


def run(*, out: Path, shard: int = 0, shards: int = 1, options: str = "{}", seed: int = 0) -> None:
    """Write the index and, beside it, the archive of every `shards`-th model, beginning with number `shard`.

    Args:
        out: path of the index; the archive (.zip) gets the same name.
        shard: which part, 0 to shards - 1.
        shards: number of parts.
        options: JSON of the config section `assets`.
        seed: of the models.
    """
    config = read_options(LibraryOptions, options)
    unknown = sorted(set(config.counts) - set(ALL))
    if unknown:
        names = f"one of {', '.join(ALL)}"
        raise InputError("assets.counts", f"no category '{unknown[0]}'.", names, code="E-CATEGORY-UNKNOWN")
    wanted = [(category, k) for category, count in sorted(config.counts.items()) for k in range(count)]
    if not wanted:
        what = "the library would be empty."
        raise InputError("assets", what, "set assets.counts or assets.folders", code="E-LIBRARY-EMPTY")
    if not 0 <= shard < shards:
        raise InputError("--shard", f"{shard} is not below --shards {shards}.", code="E-SHARD-NUMBER")
    with TemporaryDirectory(prefix="acdc-library-") as folder:
        for category, k in progress(wanted[shard::shards], "models", len(wanted[shard::shards])):
            make(category, k, seed, Path(folder), config.variations)
        write_part(out, Path(folder))


def make(category: str, index: int, seed: int, folder: Path, variations: bool = True) -> Asset:
    """Build the `index`-th procedural model of a category; without `variations` it is a template."""
    recipe = sample(category, index, seed, variations)
    name = model_name(category, index)
    return build(recipe, None, folder / name, name, category, f"procedural: {recipe.generator}, seed {seed}")
