"""Triangles of things that stand in the rooms: procedural furniture, and some kinds that the library lacks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from trimesh import Trimesh

from plugins.furniture.catalogue import CATEGORIES
from plugins.furniture.model import Model, Part, fit_model, part, parts_of
from plugins.furniture.shapes import cushion, lathe, rod, slab

Array = NDArray[np.float64]
Rng = np.random.Generator

CELLS = 24  # of a height map, per side
PAINT = [0.5, 0.5, 0.5]  # nobody looks at their colours
HARD_EDGE = 0.15  # of the edge of a cushion, as a share of its least side


@dataclass(frozen=True)
class Solid:
    """A thing: z up, front towards +x, box centred in x and y, standing on z = 0.

    Attributes:
        vertices: (V, 3) metres.
        faces: (F, 3).
        mirrors: (F,) which faces do.
        heights: (CELLS, CELLS) of what it shows from above, over its box in x and y; NaN: nothing.
    """

    kind: str
    vertices: Array
    faces: NDArray[np.int64]
    mirrors: NDArray[np.bool_]
    heights: Array

    @cached_property
    def size(self) -> Array:
        """(3,) metres."""
        return np.asarray(np.ptp(self.vertices, axis=0))


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
    mirrors = number == _glass(parts) if kind == "mirror" else np.zeros(len(faces), dtype=bool)
    return Solid(kind, vertices, faces, mirrors, _heights(vertices, faces))


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


def _soft(low: Sequence[float], high: Sequence[float]) -> Trimesh:
    least = float(np.min(np.subtract(high, low)))
    return cushion(low, high, HARD_EDGE * least)


def _office_chair(rng: Rng) -> list[Part]:
    """Five feet, a column, a seat, a back, sometimes arms."""
    seat, reach, width = rng.uniform(0.42, 0.55), rng.uniform(0.26, 0.34), rng.uniform(0.42, 0.52)
    turns = 2 * np.pi * (np.arange(5) / 5 + rng.random())
    parts = [part(rod([0, 0, 0.1], [reach * np.cos(t), reach * np.sin(t), 0.05], 0.02), PAINT) for t in turns]
    parts += [part(rod([0, 0, 0.08], [0, 0, seat], 0.03), PAINT)]
    parts += [part(_soft([-width / 2, -width / 2, seat], [width / 2, width / 2, seat + 0.08]), PAINT)]
    tall = rng.uniform(0.4, 0.75)
    parts += [part(_soft([-width / 2 - 0.06, -0.21, seat + 0.1], [-width / 2, 0.21, seat + 0.1 + tall]), PAINT)]
    parts += [part(rod([-width / 2 + 0.1, 0, seat], [-width / 2 - 0.03, 0, seat + 0.2], 0.03), PAINT)]
    if rng.random() < 0.6:
        for side in (-1, 1):
            y, top = side * (width / 2 + 0.03), seat + rng.uniform(0.2, 0.26)
            parts += [part(rod([0, y, seat + 0.03], [0, y, top], 0.018), PAINT)]
            parts += [part(slab([0, y, top], [0.28, 0.07, 0.03]), PAINT)]
    return parts


def _make_heap(rng: Rng) -> list[Part]:
    """A box, a can, a ball or a few of them as one thing: toys, bags, tools, food."""
    scale, parts = rng.uniform(0.05, 0.3), []
    for _ in range(int(rng.choice([1, 1, 2, 3, 5]))):
        size = scale * rng.uniform(0.3, 1.0, 3)
        x, y = rng.uniform(-0.3, 0.3, 2) * scale
        kind = rng.integers(3)
        if kind == 0:
            parts.append(part(slab([x, y, size[2] / 2], size), PAINT))
        elif kind == 1:
            parts.append(
                part(_soft([x - size[0] / 2, y - size[1] / 2, 0], [x + size[0] / 2, y + size[1] / 2, size[2]]), PAINT)
            )
        else:
            low, high = rng.uniform(0.2, 0.6, 2) * size[0]
            turned = lathe([(0, 0), (low, 0), (high, size[2]), (0, size[2])])
            turned.apply_translation([x, y, 0])
            parts.append(part(turned, PAINT))
    return parts


def _sheet(rng: Rng) -> list[Part]:
    """A paper, a magazine, a tray, a rug's little cousin: flat."""
    return [part(slab([0, 0, 0.004], [*rng.uniform(0.15, 0.4, 2), rng.uniform(0.004, 0.02)]), PAINT)]


OTHERS: dict[str, Callable[[Rng], list[Part]]] = {
    "office_chair": _office_chair,
    "heap": _make_heap,
    "sheet": _sheet,
}
