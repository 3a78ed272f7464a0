"""Command `cousins`: cousins.png, each object beside its cousins."""

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from roomkin.stages.contracts import Cousins, InputError, read_json, write_atomically
from roomkin.stages.contracts.cousins import Cousin
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.images import LETTERS, TILE
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.masks import darken_rest
from roomkin.stages.matching.snapshots import SceneObjects, Snapshots


def run(
    *,
    cousins: Path,
    objects: Path,
    image: Path,
    snapshots: list[Path],
    out: Path,
    library: Path | None = None,
    in_place: tuple[str, ...] = (),
) -> None:
    """Draw what `match` wrote, ours or another's.

    Args:
        cousins: cousins.json.
        objects: objects.json of extraction, with masks.png and depth.npz beside it.
        image: the scene's picture.
        snapshots: shards of snapshots (.h5).
        out: the picture to write.
        library: library.json, its archives beside it, for `in_place`.
        in_place: the module of a package that shows cousins in the object's place, too.
    """
    scene = SceneObjects(objects, image)
    show = import_module(in_place[0]).InPlace(scene, library).show if in_place and library else None
    write_picture(out, read_json(Cousins, cousins), scene, snapshots, show)


LINE = 20  # pixels of a line of a caption
Picture = NDArray[np.uint8]
InPlace = Callable[[SceneObject, Cousin], tuple[Picture, str] | None]


def write_picture(
    path: Path, result: Cousins, scene: SceneObjects, snapshots: Sequence[Path], in_place: InPlace | None = None
) -> None:
    """Write one row per object: its crop, then its cousins with asset, distance and yaw.

    With `in_place`: below each cousin what it looks like in the object's place, with a caption; None: it tells nothing.
    """
    rows = max(1, len(result.objects))
    columns = 1 + max((len(entry.cousins) for entry in result.objects), default=0)
    margin = LINE // 2
    below = TILE + 2 * LINE + margin  # a caption has two lines, that of what is in place three
    step_x, step_y = TILE + margin, below + (TILE + 3 * LINE + margin if in_place else 0)
    page = Image.new("RGB", (columns * step_x + margin, rows * step_y + margin), "white")
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(LETTERS)
    shards = Snapshots(snapshots)
    items = {item.id: item for item in scene.objects.objects}
    for row, entry in enumerate(result.objects):
        y = margin + row * step_y
        item = items.get(entry.id)
        if item is None:
            what = f"names '{entry.id}', which is no object of the scene."
            raise InputError("--cousins", what, "match it again", code="E-SCENE-MIXED")
        view = scene.view(item)
        if view.mask.any():
            page.paste(Image.fromarray(_fit(darken_rest(view))), (margin, y))
        parts = [count(n, noun) for n, noun in ((item.doors, "door"), (item.drawers, "drawer")) if n]
        draw.text((margin, y + TILE + 2), f"{entry.id}\n{', '.join(parts)}", "black", font)
        if entry.status == "failed":
            draw.text((margin + step_x, y + TILE // 2), f"failed: {entry.reason}", "black", font)
        for column, cousin in enumerate(entry.cousins, 1):
            x = margin + column * step_x
            tile = shards.picture(cousin.asset, cousin.orientation.yaw)
            page.paste(Image.fromarray(_fit(tile)), (x, y))
            yaw = f"{np.degrees(cousin.orientation.yaw):.0f}°"
            draw.text((x, y + TILE + 2), f"{cousin.asset}\n{cousin.distance:.3f}  {yaw}", "black", font)
            placed = in_place(item, cousin) if in_place else None
            if placed:
                page.paste(Image.fromarray(_fit(placed[0])), (x, y + below))
                draw.text((x, y + below + TILE + 2), placed[1], "black", font)
        draw.line([(margin, y + step_y - 4), (page.width - margin, y + step_y - 4)], "darkgrey")
    with write_atomically(path) as temporary:
        page.save(temporary)


def _fit(picture: Picture) -> Picture:
    """A picture scaled to fit into a (TILE, TILE) square, centered on white."""
    scale = TILE / max(picture.shape[:2])
    width, height = (max(1, round(side * scale)) for side in picture.shape[1::-1])
    small = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
    tile = np.full((TILE, TILE, 3), 255, np.uint8)
    x, y = (TILE - width) // 2, (TILE - height) // 2
    tile[y : y + height, x : x + width] = small
    return tile
