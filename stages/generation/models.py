"""Models of the library as generation needs them: sized, as meshes and what collides, in the picture's colors.

In the asset frame, every joint closed. Asset folders never change: their names are keys of their content.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import MultiPoint, Polygon
from trimesh import Trimesh

from roomkin.stages.articulated.asset_folder import read_model
from roomkin.stages.articulated.model import list_collisions, measure_closed_box
from roomkin.stages.articulated.resizing import has_size, load_maker, resize_model
from roomkin.stages.articulated.urdf_writer import as_written
from roomkin.stages.contracts.generated import GAMMA
from roomkin.stages.contracts.objects import Objects
from roomkin.stages.generation.placed import Placed, Prism
from roomkin.stages.geometry.masks import MIN_PIXELS

RGB = tuple[float, float, float]  # linear
SHADING = (0.3, 0.9)  # quantiles of lightness between which a surface is neither in shadow nor glaring; chosen
ROUNDS = 3  # in each the half of the pixels that is nearest to the median gives the next one; chosen


def measure_colors(rgb: NDArray[np.uint8], masks: NDArray[np.uint16], objects: Objects) -> dict[str, RGB]:
    """The color that most of every object has in the picture, by id; of what shows too few pixels none.

    The light's tint stays in it, as in the colors of floor and walls (look.json).

    Args:
        rgb: the picture (H, W, 3).
        masks: of the objects (H, W).
    """
    lab = cv2.cvtColor(rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    pixels = {item.id: lab[masks == item.mask] for item in objects.objects}
    return {name: find_main_color(each) for name, each in pixels.items() if len(each) >= MIN_PIXELS}


def find_main_color(lab: NDArray[np.float32]) -> RGB:
    """The color of most of N pixels (N, 3), Lab, as linear rgb: away from shadows and glare, others left out."""
    low, high = np.quantile(lab[:, 0], SHADING)
    kept = lab[(lab[:, 0] >= low) & (lab[:, 0] <= high)]
    for _ in range(ROUNDS):
        far = np.linalg.norm(kept - np.median(kept, axis=0), axis=1)
        kept = kept[far <= np.median(far)]
    shown = cv2.cvtColor(np.median(kept, axis=0).astype(np.float32)[None, None], cv2.COLOR_LAB2RGB)[0, 0]
    r, g, b = (np.clip(shown.astype(float), 0, 1) ** GAMMA).round(3).tolist()
    return r, g, b


def paint(item: Placed, color: RGB | None) -> Placed:
    """The item in the color of its object, by its recipe; a model without one, and one of no known color, stays."""
    if color is None:
        return item
    if item.asset.recipe is None:
        return replace(item, steps=(*item.steps, "in its own colors: a model that is no recipe's cannot be painted"))
    before = item.asset.recipe
    painted = load_maker().paint(before, color)
    finish: Any = {key: value for key, value in painted.parameters.items() if before.parameters[key] != value}
    asset = item.asset.model_copy(update={"recipe": painted})
    return replace(item, asset=asset, finish=finish)


def resize(item: Placed) -> Placed:
    """The item with a model of the size of its box and that model's collision prisms, rounded as in its files."""
    if has_size(item.asset, item.size.tolist()):
        return replace(item, prisms=to_prisms(read_collisions(item.folder)))
    robot = resize_model(item.folder, item.asset, item.size.tolist()).robot
    pieces = list_collisions(as_written(robot))
    low, high = (measure_closed_box(robot).round(6) + 0.0).tolist()
    sized = {"box_min": tuple(low), "box_max": tuple(high), "mass": round(robot.mass, 4)}
    return replace(item, asset=item.asset.model_copy(update=sized), robot=robot, prisms=to_prisms(pieces))


def to_prisms(pieces: Iterable[Trimesh]) -> tuple[Prism, ...]:
    """Upright prisms around convex pieces; without those that have no area from above."""
    found = []
    for piece in pieces:
        vertices = np.asarray(piece.vertices, dtype=float)
        hull = MultiPoint(vertices[:, :2]).convex_hull
        if isinstance(hull, Polygon):
            low, high = vertices[:, 2].min(), vertices[:, 2].max()
            found.append(Prism(np.array(hull.exterior.coords)[:-1], float(low), float(high), vertices))
    return tuple(found)


@lru_cache(maxsize=64)
def read_collisions(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return list_collisions(read_model(folder))
