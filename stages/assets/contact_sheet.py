"""One picture that shows a shard: all representative snapshots by name."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

COLUMNS, TILE = 10, 128  # pictures in a row, pixels of a side


def contact_sheet(rgb: NDArray[np.uint8], ids: list[str]) -> Image.Image:
    """Sheet of `rgb` (A, V, H, W, 3), whose last view is the representative."""
    rows = max(1, -(-len(ids) // COLUMNS))  # a shard may be of broken models alone
    sheet = Image.new("RGB", (COLUMNS * TILE, rows * TILE), "white")
    draw = ImageDraw.Draw(sheet)
    for index, name in enumerate(ids):
        corner = index % COLUMNS * TILE, index // COLUMNS * TILE
        tile = Image.fromarray(rgb[index, -1]).resize((TILE, TILE), Image.Resampling.LANCZOS)
        sheet.paste(tile, corner)
        draw.text(corner, name, fill="black")
    return sheet
