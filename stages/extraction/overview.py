"""`overview.png`: the picture with outlines, names, mounting types and projected boxes."""

import colorsys
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from stages.contracts.objects import Objects, SceneObject
from stages.geometry.boxes import UprightBox, corners
from stages.geometry.cameras import project
from stages.geometry.frames import apply, inverse

SCALE = 2  # drawn larger, so that lines and letters are smooth
LETTERS = 22  # pixels
GOLDEN = 0.618034  # steps of hue that keep neighbours apart
Colour = tuple[int, int, int]


def colour_of(index: int) -> Colour:
    """A bright colour, different from that of the neighbouring indices."""
    red, green, blue = colorsys.hsv_to_rgb((0.02 + index * GOLDEN) % 1.0, 0.75, 1.0)
    return round(255 * red), round(255 * green), round(255 * blue)


def _tinted(rgb: NDArray[np.uint8], masks: NDArray[np.uint16], colours: dict[int, Colour]) -> NDArray[Any]:
    image = cv2.resize(rgb, None, fx=SCALE, fy=SCALE, interpolation=cv2.INTER_CUBIC)
    for value, colour in colours.items():
        mask = cv2.resize((masks == value).astype(np.uint8), (image.shape[1], image.shape[0]))
        image[mask > 0] = (0.75 * image[mask > 0] + 0.25 * np.array(colour)).astype(np.uint8)
        outline, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(image, outline, -1, colour, 2, cv2.LINE_AA)
    return image


def _wireframe(canvas: ImageDraw.ImageDraw, item: SceneObject, objects: Objects, colour: Colour) -> None:
    if item.box is None:
        return
    box = UprightBox(item.box.center, item.box.size, item.box.yaw)
    in_camera = apply(inverse(np.array(objects.floor_from_camera)), corners(box))
    pixels = project(in_camera, np.array(objects.intrinsics)) * SCALE
    ring = [(k, (k + 1) % 4) for k in range(4)]  # of its foot; its top is 4 corners on
    for a, b in [*ring, *((a + 4, b + 4) for a, b in ring), *((a, a + 4) for a, _ in ring)]:
        if np.isfinite(pixels[[a, b]]).all():
            canvas.line([*map(tuple, pixels[[a, b]])], fill=colour, width=2)


def _caption(item: SceneObject) -> str:
    parts = [item.id]
    if item.mounting is not None:
        parts.append(f"mount {item.mounting.type}")
        parts += [wall.replace("wall_", "w") for wall in item.mounting.walls]
    if item.doors or item.drawers:
        parts.append(f"{item.doors}d {item.drawers}dr")
    return "  ".join(parts)


class _Captions:
    """Captions that do not cover each other: one that would is moved up."""

    def __init__(self, canvas: ImageDraw.ImageDraw) -> None:
        self.canvas = canvas
        self.font = ImageFont.load_default(LETTERS)
        self.taken: list[tuple[float, float, float, float]] = []

    def write(self, text: str, at: tuple[float, float], colour: Colour) -> None:
        """Write `text` centred above the point."""
        x0, y0, x1, y1 = self.canvas.textbbox(at, text, font=self.font, anchor="mb")
        half, height = (x1 - x0) / 2 + 5, y1 - y0 + 8
        x = min(max(at[0], half), self.canvas.im.size[0] - half)
        y = max(at[1], height)
        for left, top, right, bottom in sorted(self.taken, key=lambda box: -box[3]):
            if x - half < right and x + half > left and y - height < bottom and y > top:
                y = top
        self.taken.append((x - half, y - height, x + half, y))
        self.canvas.rectangle(self.taken[-1], fill=(20, 20, 20), outline=colour)
        self.canvas.text((x, y - 4), text, fill=(255, 255, 255), font=self.font, anchor="mb")


def draw_overview(rgb: NDArray[np.uint8], masks: NDArray[np.uint16], objects: Objects) -> Image.Image:
    """The picture at twice its size; objects that failed are listed at the bottom with their reason."""
    good = [item for item in objects.objects if item.status == "ok"]
    colours = {item.mask: colour_of(k) for k, item in enumerate(good)}
    image = Image.fromarray(_tinted(rgb, masks, colours))
    canvas = ImageDraw.Draw(image)
    for item in good:
        _wireframe(canvas, item, objects, colours[item.mask])
    captions = _Captions(canvas)
    for item in sorted(good, key=lambda item: -item.mask):
        if item.pixels is not None:
            x0, y0, x1, _ = item.pixels
            captions.write(_caption(item), ((x0 + x1) * SCALE / 2, y0 * SCALE), colours[item.mask])
    failed = [f"{item.id}: {item.reason}" for item in objects.objects if item.status == "failed"]
    for k, line in enumerate(failed):
        captions.write(line, (image.width / 2, image.height - 8 - 36 * k), (255, 80, 80))
    return image
