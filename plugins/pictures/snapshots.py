"""Command `snapshots`: contact sheets of the snapshots."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.features import MAKE_SNAPSHOTS, open_snapshots
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.images import COLUMNS, LETTERS, TILE


def run(*, snapshots: tuple[Path, ...]) -> None:
    """Write a contact sheet (.png) beside each shard.

    Args:
        snapshots: shards (.h5), each with its .json beside it.
    """
    for shard in snapshots:
        sidecar, file = open_snapshots(shard)
        with file, explain_unreadable(shard, "snapshot file", MAKE_SNAPSHOTS):  # a chunk may be damaged
            sheet = contact_sheet(file["rgb"], sidecar.assets)
        with write_atomically(shard.with_suffix(".png")) as path:
            sheet.save(path)


def contact_sheet(rgb: NDArray[np.uint8], ids: list[str]) -> Image.Image:
    """Sheet of `rgb` (A, V, H, W, 3), whose last view is the representative."""
    rows = max(1, -(-len(ids) // COLUMNS))  # a shard may be of broken models alone
    sheet = Image.new("RGB", (COLUMNS * TILE, rows * TILE), "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(LETTERS)
    for index, name in enumerate(ids):
        corner = index % COLUMNS * TILE, index // COLUMNS * TILE
        tile = Image.fromarray(rgb[index, -1]).resize((TILE, TILE), Image.Resampling.LANCZOS)
        sheet.paste(tile, corner)
        draw.text(corner, name, fill="black", font=font)
    return sheet
