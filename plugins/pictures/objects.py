"""Command `objects`: overview.png, the picture with outlines, names, how each thing is held, and projected boxes."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from roomkin.stages.contracts import Objects, read_json, write_atomically
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.extracted import read_object_masks
from roomkin.stages.contracts.images import Color, check_size, color_of, read_rgb
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.geometry.frames import invert_transform, project, transform_points

WIDTH = 1280  # pixels to which every picture is drawn: pages show it at about half of that, whatever its own size
LINE, PADDING = 3, 5  # pixels
HELD = {1: "hangs on", 2: "stands free", 3: "stands at"}  # by the type of `Mounting`, before its walls


def run(*, objects: Path, image: Path, out: Path) -> None:
    """Draw what `extract` wrote, ours or another's.

    Args:
        objects: objects.json, with masks.png beside it.
        image: the scene's picture.
        out: the picture to write.
    """
    found, picture = read_json(Objects, objects), read_rgb(image)
    check_size(image, picture, found.width, found.height, objects.name)
    with write_atomically(out) as path:
        draw_overview(picture, read_object_masks(objects, found), found).save(path)


def _tint_masks(
    rgb: NDArray[np.uint8], masks: NDArray[np.uint16], colors: dict[int, Color], scale: float
) -> NDArray[Any]:
    size, finest = (WIDTH, round(scale * rgb.shape[0])), cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    image = cv2.resize(rgb, size, interpolation=finest)
    for value, color in colors.items():
        mask = cv2.resize((masks == value).astype(np.uint8), size)
        image[mask > 0] = (0.75 * image[mask > 0] + 0.25 * np.array(color)).astype(np.uint8)
        outline, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(image, outline, -1, color, LINE, cv2.LINE_AA)
    return image


def _wireframe(canvas: ImageDraw.ImageDraw, item: SceneObject, objects: Objects, color: Color, scale: float) -> None:
    if item.box is None:
        return
    box = UprightBox(item.box.center, item.box.size, item.box.yaw)
    in_camera = transform_points(invert_transform(np.array(objects.floor_from_camera)), corners(box))
    pixels = project(in_camera, np.array(objects.intrinsics)) * scale
    ring = [(k, (k + 1) % 4) for k in range(4)]  # of its lower face; the upper one is 4 corners on
    for a, b in [*ring, *((a + 4, b + 4) for a, b in ring), *((a, a + 4) for a, _ in ring)]:
        if np.isfinite(pixels[[a, b]]).all():
            canvas.line([*map(tuple, pixels[[a, b]])], fill=color, width=LINE)


def _caption(item: SceneObject) -> str:
    parts = []
    if item.mounting is not None:
        walls = " and ".join(wall.replace("_", " ") for wall in item.mounting.walls)
        parts.append(f"{HELD[item.mounting.type]} {walls}".strip())
    parts += [count(number, noun) for number, noun in ((item.doors, "door"), (item.drawers, "drawer")) if number]
    return "\n".join([item.id.replace("_", " "), *([", ".join(parts)] if parts else [])])


class _Captions:
    """Captions that lie in the picture and do not cover each other."""

    def __init__(self, canvas: ImageDraw.ImageDraw) -> None:
        self.canvas = canvas
        self.font = ImageFont.load_default(26)
        self.taken: list[tuple[float, float, float, float]] = []

    def write(self, text: str, at: tuple[float, float], color: Color) -> None:
        """Write `text` centered above the point, or at the nearest free place above or below."""
        x0, y0, x1, y1 = self.canvas.textbbox((0, 0), text, font=self.font)
        width, height = x1 - x0 + 2 * PADDING, y1 - y0 + 2 * PADDING
        across, down = self.canvas.im.size
        left, wanted = min(max(at[0] - width / 2, 0), across - width), max(at[1] - height, 0)
        above = [box for box in self.taken if left < box[2] and left + width > box[0]]
        tops = [wanted, *(box[1] - height for box in above), *(box[3] for box in above)]
        free = [
            top
            for top in tops
            if 0 <= top <= down - height and all(top >= box[3] or top + height <= box[1] for box in above)
        ]
        top = min(free, key=lambda one: (one > wanted, abs(one - wanted)), default=wanted)
        self.taken.append((left, top, left + width, top + height))
        self.canvas.rectangle(self.taken[-1], fill=(20, 20, 20), outline=color)
        self.canvas.text((left + PADDING - x0, top + PADDING - y0), text, fill=(255, 255, 255), font=self.font)


def draw_overview(rgb: NDArray[np.uint8], masks: NDArray[np.uint16], objects: Objects) -> Image.Image:
    """The picture, `WIDTH` pixels wide; objects that failed are listed at its lower edge with their reason."""
    good = [item for item in objects.objects if item.status == "ok"]
    colors = {item.mask: color_of(k) for k, item in enumerate(good)}
    scale = WIDTH / rgb.shape[1]
    image = Image.fromarray(_tint_masks(rgb, masks, colors, scale))
    canvas = ImageDraw.Draw(image)
    for item in good:
        _wireframe(canvas, item, objects, colors[item.mask], scale)
    captions = _Captions(canvas)
    for item in sorted(good, key=lambda item: -item.mask):
        if item.pixels is not None:
            x0, y0, x1, _ = item.pixels
            captions.write(_caption(item), ((x0 + x1) * scale / 2, y0 * scale), colors[item.mask])
    failed = [f"{item.id}: {item.reason}" for item in objects.objects if item.status == "failed"]
    for line in failed:  # one above the other
        captions.write(line, (image.width / 2, image.height - 8), (255, 80, 80))
    return image
