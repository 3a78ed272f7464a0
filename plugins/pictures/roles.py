"""Verb `roles`: pictures of the assets of a task, each with its role, handle and hinge."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from stages.contracts import TaskAssets, read_json
from stages.contracts.arrays import explain_unreadable
from stages.contracts.files import write_atomically
from stages.contracts.images import COLUMNS, LETTERS, TILE
from stages.contracts.policies import TaskAsset
from stages.contracts.snapshot_file import AGAIN, open_snapshots

INK, PAPER = "#282828", "white"


def run(*, assets: Path, snapshots: tuple[Path, ...], out: Path, splits: Path) -> None:
    """Draw the representative snapshots of the roles, and of the validation and test assets.

    Args:
        assets: the experiment's assets (contract TaskAssets).
        snapshots: shards (.h5), each with its .json beside it.
        out: picture of the roles to write.
        splits: picture of the validation and test assets to write.
    """
    plan = read_json(TaskAssets, assets)
    unseen = [*plan.validation_assets, *plan.test_assets]
    views = representatives({item.asset for item in [*plan.assets, *unseen]}, snapshots)
    for picture, items in ((out, plan.assets), (splits, unseen)):
        with write_atomically(picture) as path:
            sheet_of(items, views).save(path, "PNG")


def sheet_of(items: list[TaskAsset], views: dict[str, NDArray[np.uint8]]) -> Image.Image:
    """The assets in rows, each with its caption; an asset without a view leaves its place empty."""
    rows, height = max(1, -(-len(items) // COLUMNS)), TILE + 6 * LETTERS  # with four lines of text
    sheet = Image.new("RGB", (COLUMNS * TILE, rows * height), PAPER)
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(LETTERS)
    for number, item in enumerate(items):
        x, y = number % COLUMNS * TILE, number // COLUMNS * height
        if item.asset in views:
            sheet.paste(Image.fromarray(views[item.asset]).resize((TILE, TILE), Image.Resampling.LANCZOS), (x, y))
        pen.text((x + 4, y + TILE + 2), caption(item), INK, font, spacing=2)
    return sheet


def caption(item: TaskAsset) -> str:
    """Role, model, handle and hinge, in four lines."""
    distance = f", {item.distance:.2f} away" if item.distance else ""
    hinge = "slides" if item.hinge == "slide" else f"hinge {item.hinge}"
    meets = f"{item.handle} {item.handle_length:.2f} m, {hinge}\nfront at {item.panel_height:.2f} m"
    return f"{item.role.replace('_', ' ')}{distance}\n{item.asset}\n{meets}"


def representatives(assets: set[str], snapshots: tuple[Path, ...]) -> dict[str, NDArray[np.uint8]]:
    """The representative snapshot (H, W, 3) of each of the assets that the shards hold."""
    views: dict[str, NDArray[np.uint8]] = {}
    for shard in snapshots:
        sidecar, file = open_snapshots(shard)
        with file, explain_unreadable(shard, "snapshot file", AGAIN):  # a chunk may be damaged
            views |= {name: file["rgb"][k, -1] for k, name in enumerate(sidecar.assets) if name in assets}
    return views
