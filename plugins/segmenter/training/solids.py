"""Triangles of things that stand in the rooms: procedural furniture, and some kinds that the library lacks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from trimesh import Trimesh

from plugins.furniture.catalogue import CATEGORIES
from plugins.furniture.finishes import MATERIALS
from plugins.furniture.model import Model, Part, fit_model, part, parts_of
from plugins.furniture.shapes import cushion, lathe, rod, slab
from plugins.furniture.textures import SIDE, pattern_of

Array = NDArray[np.float64]
Rng = np.random.Generator

CELLS = 24  # of a height map, per side
PATTERNS = [(name, number) for name, kind in MATERIALS.items() if kind.repeat for number in range(kind.patterns)]
HARD_EDGE = 0.15  # of the edge of a cushion, as a share of its least side


@dataclass(frozen=True)
class Solid:
    """A thing: z up, front towards +x, box centred in x and y, standing on z = 0.

    Attributes:
        vertices: (V, 3) metres.
        faces: (F, 3).
        part: (F,) which part of it a face is of.
        colours: (P, 3) of each part, 0 to 1, as screens show them.
        patterns: (P,) rows of `pattern_table`.
        repeat: (P,) metres that a pattern covers.
        heights: (CELLS, CELLS) of what it shows from above, over its box in x and y; NaN: nothing.
        mirror: part that mirrors; -1: none.
    """

    kind: str
    vertices: Array
    faces: NDArray[np.int64]
    part: NDArray[np.int64]
    colours: Array
    patterns: NDArray[np.int64]
    repeat: Array
    heights: Array
    mirror: int = -1

    @cached_property
    def size(self) -> Array:
        """(3,) metres."""
        return np.asarray(np.ptp(self.vertices, axis=0))


@cache
def pattern_table() -> NDArray[np.float32]:
    """(K, SIDE, SIDE) factors on a colour; row 0 is plain."""
    plain = np.ones((SIDE, SIDE))
    found = [plain, *(pattern_of(*name) for name in PATTERNS)]
    return np.stack([plain if shades is None else shades for shades in found]).astype(np.float32)


def make_solid(kind: str, rng: Rng, index: int) -> Solid:
    """A thing of a category of the library, or of `OTHERS`."""
    if kind in OTHERS:
        return solid_of(kind, Model(OTHERS[kind](rng)))
    sampled = CATEGORIES[kind].sample(rng, index)
    return solid_of(kind, fit_model(sampled.recipe.build(sampled.size), sampled.size))


def solid_of(kind: str, model: Model) -> Solid:
    """The triangles of a model, its joints closed."""
    parts = list(parts_of(model))
    sizes = np.cumsum([0, *(len(each.mesh.vertices) for each in parts)])
    vertices = np.concatenate([each.mesh.vertices for each in parts])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices = vertices - [*(low + high)[:2] / 2, low[2]]
    faces = np.concatenate([each.mesh.faces + start for each, start in zip(parts, sizes, strict=False)])
    number = np.repeat(np.arange(len(parts)), [len(each.mesh.faces) for each in parts])
    colours = np.array([each.colour for each in parts]) ** (1 / 2.2)
    names = [(each.finish.material, each.finish.pattern) for each in parts]
    rows = np.array([1 + PATTERNS.index(name) if name in PATTERNS else 0 for name in names])
    repeat = np.array([(MATERIALS[material].repeat or (1.0, 1.0))[0] for material, _ in names])
    mirror = _glass(parts) if kind == "mirror" else -1
    return Solid(kind, vertices, faces, number, colours, rows, repeat, _heights(vertices, faces), mirror)


def _glass(parts: Sequence[Part]) -> int:
    """The part of a mirror that faces +x with the largest area."""
    sizes = [np.ptp(each.mesh.vertices, axis=0) for each in parts]
    return int(np.argmax([size[1] * size[2] for size in sizes]))


def _heights(vertices: Array, faces: NDArray[np.int64]) -> Array:
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(vertices.astype(np.float32)), o3d.core.Tensor.from_numpy(faces.astype(np.uint32))
    )
    size = np.ptp(vertices, axis=0)
    steps = (np.arange(CELLS) + 0.5) / CELLS - 0.5
    x, y = np.meshgrid(steps * size[0], steps * size[1], indexing="ij")
    above = size[2] + 1.0
    rays = np.stack([x, y, np.full_like(x, above), 0 * x, 0 * x, np.full_like(x, -1.0)], axis=-1)
    length = scene.cast_rays(o3d.core.Tensor.from_numpy(rays.astype(np.float32)))["t_hit"].numpy().astype(float)
    return np.where(np.isfinite(length), above - length, np.nan)


def _colour(rng: Rng) -> list[float]:
    grey = rng.uniform(0.02, 0.8)
    return np.clip(grey * (1 + rng.uniform(-0.6, 0.6, 3)), 0.01, 0.9).tolist()


def _soft(low: Sequence[float], high: Sequence[float]) -> Trimesh:
    least = float(np.min(np.subtract(high, low)))
    return cushion(low, high, HARD_EDGE * least)


def _office_chair(rng: Rng) -> list[Part]:
    """Five feet, a column, a seat, a back, sometimes arms."""
    dark, cloth = ([c] * 3 if rng.random() < 0.7 else _colour(rng) for c in rng.uniform(0.02, 0.1, 2))
    seat, reach, width = rng.uniform(0.42, 0.55), rng.uniform(0.26, 0.34), rng.uniform(0.42, 0.52)
    turns = 2 * np.pi * (np.arange(5) / 5 + rng.random())
    parts = [part(rod([0, 0, 0.1], [reach * np.cos(t), reach * np.sin(t), 0.05], 0.02), dark) for t in turns]
    parts += [part(rod([0, 0, 0.08], [0, 0, seat], 0.03), dark)]
    parts += [part(_soft([-width / 2, -width / 2, seat], [width / 2, width / 2, seat + 0.08]), cloth)]
    tall = rng.uniform(0.4, 0.75)
    parts += [part(_soft([-width / 2 - 0.06, -0.21, seat + 0.1], [-width / 2, 0.21, seat + 0.1 + tall]), cloth)]
    parts += [part(rod([-width / 2 + 0.1, 0, seat], [-width / 2 - 0.03, 0, seat + 0.2], 0.03), dark)]
    if rng.random() < 0.6:
        for side in (-1, 1):
            y, top = side * (width / 2 + 0.03), seat + rng.uniform(0.2, 0.26)
            parts += [part(rod([0, y, seat + 0.03], [0, y, top], 0.018), dark)]
            parts += [part(slab([0, y, top], [0.28, 0.07, 0.03]), dark)]
    return parts


def _make_heap(rng: Rng) -> list[Part]:
    """A box, a can, a ball or a few of them as one thing: toys, bags, tools, food."""
    colours = [_colour(rng) for _ in range(int(rng.integers(1, 4)))]
    scale, parts = rng.uniform(0.05, 0.3), []
    for _ in range(int(rng.choice([1, 1, 2, 3, 5]))):
        size = scale * rng.uniform(0.3, 1.0, 3)
        x, y = rng.uniform(-0.3, 0.3, 2) * scale
        kind, paint = rng.integers(3), colours[int(rng.integers(len(colours)))]
        if kind == 0:
            parts.append(part(slab([x, y, size[2] / 2], size), paint))
        elif kind == 1:
            parts.append(
                part(_soft([x - size[0] / 2, y - size[1] / 2, 0], [x + size[0] / 2, y + size[1] / 2, size[2]]), paint)
            )
        else:
            low, high = rng.uniform(0.2, 0.6, 2) * size[0]
            turned = lathe([(0, 0), (low, 0), (high, size[2]), (0, size[2])])
            turned.apply_translation([x, y, 0])
            parts.append(part(turned, paint))
    return parts


def _sheet(rng: Rng) -> list[Part]:
    """A paper, a magazine, a tray, a rug's little cousin: flat."""
    return [part(slab([0, 0, 0.004], [*rng.uniform(0.15, 0.4, 2), rng.uniform(0.004, 0.02)]), _colour(rng))]


OTHERS: dict[str, Callable[[Rng], list[Part]]] = {
    "office_chair": _office_chair,
    "heap": _make_heap,
    "sheet": _sheet,
}
