"""What the page says of the asset library."""

from collections import Counter
from dataclasses import dataclass

from stages.contracts.files import read_json
from stages.contracts.library import Library
from stages.tables.page.files import RunFiles
from stages.tables.page.pictures import Album, Picture


@dataclass(frozen=True)
class LibraryPart:
    """How many models of what, and pictures of them."""

    models: int
    with_doors: int
    with_drawers: int
    categories: list[tuple[str, int]]
    sheets: list[Picture]


def collect(files: RunFiles, album: Album) -> LibraryPart | None:
    """The library of the run; None if there is none."""
    path = files.one("assets/library/library.json")
    if path is None:
        return None
    assets = read_json(Library, path).assets
    counts = Counter(asset.category.replace("_", " ") for asset in assets)
    sheets = files.all("assets/snapshots/shard_*.png")
    return LibraryPart(
        models=len(assets),
        with_doors=sum(asset.doors > 0 for asset in assets),
        with_drawers=sum(asset.drawers > 0 for asset in assets),
        categories=sorted(counts.items(), key=lambda item: (-item[1], item[0])),
        sheets=[album.add(sheet, f"Contact sheet of the library, {index} of {len(sheets)}")
                for index, sheet in enumerate(sheets, start=1)],
    )  # fmt: skip
