"""The page's section about the asset library."""

from collections import Counter
from dataclasses import dataclass

from plugins.report.album import Album, Picture
from plugins.report.page.files import RunFiles
from stages.contracts.files import read_json
from stages.contracts.library import Library


@dataclass(frozen=True)
class LibraryPart:
    """Number of models, by category, and pictures of them."""

    models: int
    with_doors: int
    with_drawers: int
    categories: list[tuple[str, int]]
    sheets: list[Picture]


def collect(files: RunFiles, album: Album) -> LibraryPart | None:
    """The library of the run; None if there is none."""
    path = files.find_first("assets/library/library.json")
    if path is None:
        return None
    assets, sheets = read_json(Library, path).assets, files.find_all("assets/snapshots/shard_*.png")
    counts = Counter(asset.category.replace("_", " ") for asset in sorted(assets, key=lambda asset: asset.category))
    return LibraryPart(
        models=len(assets),
        with_doors=sum(asset.doors > 0 for asset in assets),
        with_drawers=sum(asset.drawers > 0 for asset in assets),
        categories=counts.most_common(),
        sheets=[album.add(sheet, f"Contact sheet of the library, {n}") for n, sheet in enumerate(sheets, start=1)],
    )
