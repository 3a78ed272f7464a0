"""`cousins.png`: each object's crop beside its cousins in the orientation chosen for them."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from stages.contracts import Cousins, InputError, atomic
from stages.matching.crop import View, cut
from stages.matching.scene import Scene
from stages.matching.snapshots import Snapshots
from stages.matching.synthesis.shown import InPlace

TILE, CAPTION, TERMS, MARGIN = 128, 32, 46, 6
SHOWN = 8  # cousins per row
PAPER, INK, PALE = (255, 255, 255), (30, 30, 30), (150, 150, 150)
Picture = NDArray[np.uint8]


def write_picture(
    path: Path, result: Cousins, scene: Scene, snapshots: Sequence[Path], library: Path | None = None
) -> None:
    """Write one row per object: its crop, then its first cousins with asset, distance and yaw.

    With `library` (library.json, its archives beside it): below each cousin what it looks like in the object's place.
    """
    in_place = InPlace(scene, library) if library is not None else None
    rows = max(1, len(result.objects))
    columns = 1 + min(SHOWN, max((len(entry.cousins) for entry in result.objects), default=0))
    below = TILE + CAPTION + MARGIN
    step_x, step_y = TILE + MARGIN, below + (TILE + TERMS + MARGIN if in_place else 0)
    page = Image.new("RGB", (columns * step_x + MARGIN, rows * step_y + MARGIN), PAPER)
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(size=11)
    with Snapshots(snapshots) as shards:
        items = {item.id: item for item in scene.objects.objects}
        for row, entry in enumerate(result.objects):
            y = MARGIN + row * step_y
            item = items.get(entry.id)
            if item is None:
                what = f"names '{entry.id}', which is no object of the scene."
                raise InputError("--cousins", what, "match it again", code="E-SCENE-MIXED")
            view = scene.view(item)
            if view.mask.any():
                page.paste(Image.fromarray(crop_picture(view)), (MARGIN, y))
            draw.text((MARGIN, y + TILE + 2), f"{entry.id}\n{_counts(item.doors, item.drawers)}", INK, font)
            if entry.status == "failed":
                draw.text((MARGIN + step_x, y + TILE // 2), f"failed: {entry.reason}", INK, font)
            for column, cousin in enumerate(entry.cousins[:SHOWN], 1):
                x = MARGIN + column * step_x
                tile = shards.picture(cousin.asset, cousin.orientation.yaw)
                page.paste(Image.fromarray(_fit(tile)), (x, y))
                yaw = f"{np.degrees(cousin.orientation.yaw):.0f}°"
                draw.text((x, y + TILE + 2), f"{cousin.asset}\n{cousin.distance:.3f}  {yaw}", INK, font)
                placed = in_place.show(item, cousin) if in_place else None
                if placed:
                    page.paste(Image.fromarray(_fit(placed[0])), (x, y + below))
                    draw.text((x, y + below + TILE + 2), placed[1], INK, font)
            draw.line([(MARGIN, y + step_y - 4), (page.width - MARGIN, y + step_y - 4)], PALE)
    with atomic(path) as temporary:
        page.save(temporary)


def crop_picture(view: View) -> Picture:
    """The object (TILE, TILE, 3) with a little of what is around it, darkened outside its mask."""
    shade = np.where(view.mask[..., None], view.rgb, view.rgb // 3).astype(np.uint8)
    return _fit(cut(View(shade, view.mask)).rgb)


def _fit(picture: Picture) -> Picture:
    """A picture scaled to fit into a (TILE, TILE) square, centred on white."""
    scale = TILE / max(picture.shape[:2])
    width, height = (max(1, round(side * scale)) for side in picture.shape[1::-1])
    small = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
    tile = np.full((TILE, TILE, 3), 255, np.uint8)
    x, y = (TILE - width) // 2, (TILE - height) // 2
    tile[y : y + height, x : x + width] = small
    return tile


def _counts(doors: int, drawers: int) -> str:
    counts = {"door": doors, "drawer": drawers}
    return ", ".join(f"{number} {name}{'s' if number > 1 else ''}" for name, number in counts.items() if number)
