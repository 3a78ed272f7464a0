"""The maker of recipes for the core (`articulated.resizing.Maker`), and of models in other finishes (`recoloured`)."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import open3d as o3d
from trimesh import Trimesh

from roomkin.plugins.furniture.colors import ALTERNATIVES, pick
from roomkin.plugins.furniture.finishes import RGB, Finish, Surface, finish_of
from roomkin.plugins.furniture.folder import generate, make_model
from roomkin.plugins.furniture.model import parts_of
from roomkin.plugins.furniture.shapes import bounds_of
from roomkin.stages.contracts.library import Recipe
from roomkin.stages.contracts.types import LARGEST

FIXED = {"screen_colour", "panel_colour", "inside_colour"}  # the same on every model
OTHER = 0.12  # distance from the old color from which a color is another one
VIEW = (1.0, 0.5, 0.6)  # from where a thing is looked at: its front, one side and its top are seen
DETAIL = 0.3  # of the pixels of what is seen most: what has fewer is a detail, as legs and handles are; chosen
SIDE = 96  # of the picture, pixels; chosen
SHADED = 0.02  # a color that is a multiple of another, to this relative accuracy, stays its shade


def refinish(recipe: Recipe, rng: np.random.Generator) -> Recipe:
    """The recipe with another finish for every part, of what such a material is sold in.

    What was of one finish stays of one finish, a shade stays a shade of the other's new color.
    """
    new: dict[Finish, Finish] = {}

    def repaint(old: Finish) -> Finish:
        if old not in new:
            new[old] = _shade_of(old, new) or _another(old, rng)
        return new[old]

    return _change_finishes(recipe, repaint)


def paint(recipe: Recipe, color: RGB) -> Recipe:
    """The recipe with what is seen most in another color, and shades of it as its shades; details stay as they are.

    A plant stays as it is: an outline around leaves shows much of what is behind them.
    """
    seen: dict[Finish, int] = defaultdict(int)
    known = dict.fromkeys(_list_finishes(recipe))
    if any(each.material == "leaf" for each in known):
        return recipe
    parts = list(parts_of(generate(recipe)))
    for part, pixels in zip(parts, count_pixels([part.mesh for part in parts]), strict=True):
        shaded = (each for each in known if _shade_of(part.finish, {each: each}))
        base = part.finish if part.finish in known else next(shaded, None)
        if base is not None:
            seen[base] += pixels
    most = max(seen.values(), default=0)
    new = {each: each.change_color(color) for each in known if seen[each] > DETAIL * most}
    return _change_finishes(recipe, lambda old: new.get(old) or _shade_of(old, new) or old)


def count_pixels(meshes: Sequence[Trimesh]) -> list[int]:
    """How much is seen of each of some meshes that hide each other, from afar before `VIEW`."""
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    for mesh in meshes:
        corners, faces = np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32)
        scene.add_triangles(o3d.core.Tensor.from_numpy(corners), o3d.core.Tensor.from_numpy(faces))
    low, high = bounds_of(list(meshes))
    back = np.array(VIEW) / np.linalg.norm(VIEW)
    right = np.cross([0.0, 0, 1], back) / np.linalg.norm(np.cross([0.0, 0, 1], back))
    at = np.linspace(-0.5, 0.5, SIDE) * np.linalg.norm(high - low)
    across, up = (grid.reshape(-1, 1) for grid in np.meshgrid(at, at))
    origins = (low + high) / 2 + 2 * LARGEST * back + across * right + up * np.cross(back, right)
    rays = np.concatenate([origins, np.broadcast_to(-back, origins.shape)], axis=1).astype(np.float32)
    hit = scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=1)["geometry_ids"].numpy()
    return [int(np.count_nonzero(hit == number)) for number in range(len(meshes))]


def _list_finishes(recipe: Recipe) -> Iterator[Finish]:
    for key, value in recipe.parameters.items():
        if is_finish(key):
            values: Any = value if key == "colours" else [value]
            yield from map(finish_of, values)


def _change_finishes(recipe: Recipe, change: Callable[[Finish], Finish]) -> Recipe:
    """The recipe with every finish changed; one that stays is written as before."""

    def repaint(value: Surface) -> Surface:
        old = finish_of(value)
        new = change(old)
        return value if new == old else str(new)

    parameters: dict[str, Any] = dict(recipe.parameters)
    for key, value in parameters.items():
        if is_finish(key):
            parameters[key] = [repaint(each) for each in value] if key == "colours" else repaint(value)
    return recipe.model_copy(update={"parameters": parameters})


def is_finish(key: str) -> bool:
    """Whether a parameter of a recipe is a finish (or several) that may be another one."""
    return key not in FIXED and (key in ("colours", "inside") or "colour" in key)


def _another(old: Finish, rng: np.random.Generator) -> Finish:
    family = ALTERNATIVES[old.material]
    others = [finish for finish in family if np.linalg.norm(np.subtract(finish.color, old.color)) > OTHER]
    return finish_of(pick(rng, others or family))


def _shade_of(old: Finish, new: dict[Finish, Finish]) -> Finish | None:
    """The same shade of the new finish of what `old` was a shade of."""
    for base, painted in new.items():
        ratio = np.array(old.color) / np.maximum(base.color, 1e-3)
        if old.material == base.material and np.ptp(ratio) < SHADED * ratio.max():
            return painted.change_color([float(ratio.mean()) * channel for channel in painted.color])
    return None


class Maker:
    """Makes and paints our models by their recipes."""

    make_model, paint, refinish = staticmethod(make_model), staticmethod(paint), staticmethod(refinish)
