"""A scene with floor, walls and light, and its pictures for people."""

import numpy as np
import sapien
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from roomkin.stages.contracts.generated import GeneratedScene, Look
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.settling import load_items
from roomkin.stages.geometry.boxes import corners
from roomkin.stages.simulation.rendering import RenderCamera, make_scene
from roomkin.stages.simulation.room import BEYOND, add_backdrop


def furnish(generated: GeneratedScene, items: list[Placed], look: Look) -> sapien.Scene:
    """The scene in its look, to be rendered: floor, walls, furniture, and a light whose shadows reach all of it."""
    points = np.concatenate([corners(item.box) for item in items])
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - center, axis=1).max()) + BEYOND
    scene = make_scene(light=look.light, shaded=(center.tolist(), radius))
    add_backdrop(
        scene, [item.box for item in items], generated.walls, np.array(generated.floor_from_camera)[:3, 3], look
    )
    load_items(scene, items)
    return scene


SMOOTHING = 2  # rendered so many times larger and averaged; chosen


def draw_preview(scene: sapien.Scene, generated: GeneratedScene, width: int) -> NDArray[np.uint8]:
    """The scene as the input camera sees it, (H, width, 3); its world is the floor frame."""
    factor = SMOOTHING * width / generated.width
    height = round(generated.height * width / generated.width)
    intrinsics = np.array(generated.intrinsics) * [[factor], [factor], [1.0]]
    intrinsics[:2, 2] += (factor - 1) / 2  # pixel centers are at integers
    picture = RenderCamera(scene, intrinsics, SMOOTHING * width, SMOOTHING * height).render(generated.floor_from_camera)
    return np.asarray(Image.fromarray(picture.rgb).resize((width, height), Image.Resampling.BOX))


def resize_to(rgb: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """A picture (H, W, 3), resized to a width."""
    size = width, round(rgb.shape[0] * width / rgb.shape[1])
    return np.asarray(Image.fromarray(rgb).resize(size, Image.Resampling.LANCZOS))


def draw_side_by_side(pictures: list[tuple[str, NDArray[np.uint8]]]) -> Image.Image:
    """Pictures of one size with their titles above, three to a row."""
    height, width = pictures[0][1].shape[:2]
    columns, title_height, gap = min(3, len(pictures)), width // 12, width // 100
    rows = -(-len(pictures) // columns)
    cell_width, cell_height = width + gap, height + title_height + gap
    sheet = Image.new("RGB", (columns * cell_width - gap, rows * cell_height - gap), "white")
    canvas, font = ImageDraw.Draw(sheet), ImageFont.load_default(title_height * 2 / 3)
    for index, (title, picture) in enumerate(pictures):
        x, y = index % columns * cell_width, index // columns * cell_height
        canvas.text((x + width / 2, y + title_height / 2), title, fill="black", font=font, anchor="mm")
        sheet.paste(Image.fromarray(picture).resize((width, height)), (x, y + title_height))
    return sheet


def draw_thumbnail(pictures: list[NDArray[np.uint8]]) -> Image.Image:
    """Pictures of one size beside each other, small."""
    return Image.fromarray(np.hstack([resize_to(picture, 144) for picture in pictures]))
