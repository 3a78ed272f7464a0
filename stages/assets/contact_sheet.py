"""One picture that shows a shard: all representative snapshots by name, and the turns of a few assets."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

COLUMNS, TILE, CAPTION = 10, 128, 14
TURNING, TURNS = 4, 10  # assets whose yaw views are shown, and how many of them


def contact_sheet(rgb: NDArray[np.uint8], ids: list[str]) -> Image.Image:
    """Sheet of `rgb` (A, V, H, W, 3), whose last view is the representative."""
    tiles: list[tuple[Image.Image | None, str]] = [(Image.fromarray(rgb[k, -1]), name) for k, name in enumerate(ids)]
    tiles += [(None, "")] * (-len(tiles) % COLUMNS)
    shown = list(range(0, len(ids), max(1, len(ids) // TURNING)))[:TURNING]
    views = np.linspace(0, rgb.shape[1] - 2, min(TURNS, rgb.shape[1] - 1)).astype(int)
    for k in shown:
        row: list[tuple[Image.Image | None, str]] = [(Image.fromarray(rgb[k, view]), f"view {view}") for view in views]
        tiles += row + [(None, "")] * (-len(row) % COLUMNS)
    tiles = tiles or [(None, "")] * COLUMNS  # a shard of broken models
    height = len(tiles) // COLUMNS * (TILE + CAPTION)
    sheet = Image.new("RGB", (COLUMNS * TILE, height), "white")
    draw = ImageDraw.Draw(sheet)
    for index, (tile, caption) in enumerate(tiles):
        x, y = index % COLUMNS * TILE, index // COLUMNS * (TILE + CAPTION)
        if tile is not None:
            sheet.paste(tile.resize((TILE, TILE), Image.Resampling.LANCZOS), (x, y))
        draw.text((x + 3, y + TILE + 1), caption, fill=(40, 40, 40))
    return sheet
