"""Triangles of things that stand in the rooms: procedural furniture, and what no library has (`junk`)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.plugins.furniture.model import Model, Part, fit_model, part, parts_of
from roomkin.plugins.furniture.shapes import cushion, hull, lathe, rod, slab
from roomkin.stages.contracts.library import Placement

Array = NDArray[np.float64]
Rng = np.random.Generator


@dataclass(frozen=True, eq=False)
class Solid:
    """A thing: z up, front towards +x, box centerd in x and y, standing on z = 0; where such things are.

    vertices (V, 3) metres; faces (F, 3).
    """

    kind: str
    vertices: Array
    faces: NDArray[np.int64]
    placement: Placement

    @cached_property
    def size(self) -> Array:
        """(3,) metres."""
        return np.asarray(np.ptp(self.vertices, axis=0))

    @cached_property
    def _scene(self) -> o3d.t.geometry.RaycastingScene:
        return cast_scene(self.vertices, self.faces)

    def heights(self, points: Array) -> Array:
        """How high (N,) it is over points (N, 2) of the ground, metres; infinite: it is not there."""
        above = self.size[2] + 1.0
        rays = np.add(np.pad(points, ((0, 0), (0, 4))), [0, 0, above, 0, 0, -1])
        return above - cast_rays(self._scene, rays)["t_hit"].numpy().astype(float)


def cast_scene(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> o3d.t.geometry.RaycastingScene:
    """Triangles for rays."""
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    as_tensor = o3d.core.Tensor.from_numpy
    scene.add_triangles(as_tensor(vertices.astype(np.float32)), as_tensor(faces.astype(np.uint32)))
    return scene


def cast_rays(scene: o3d.t.geometry.RaycastingScene, rays: Array) -> dict[str, o3d.core.Tensor]:
    """What rays (..., 6), origin and direction, hit first."""
    found: dict[str, o3d.core.Tensor] = scene.cast_rays(o3d.core.Tensor.from_numpy(rays.astype(np.float32)))
    return found


def make_solid(category: str, rng: Rng, index: int) -> Solid:
    """A thing of a category of the library."""
    sampled = CATEGORIES[category].sample(rng, index)
    return solid_of(category, fit_model(sampled.recipe.build(sampled.size), sampled.size))


def solid_of(kind: str, model: Model) -> Solid:
    """The triangles of a model, its joints closed."""
    parts = [each.mesh for each in parts_of(model)]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in parts[:-1])])
    vertices = np.concatenate([mesh.vertices for mesh in parts])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(parts, starts, strict=True)])
    return Solid(kind, vertices - [*(low + high)[:2] / 2, low[2]], faces, model.placement)


PAINT = [0.5, 0.5, 0.5]  # nobody looks at their colors


def _office_chair(rng: Rng) -> list[Part]:
    """Five feet, a column, a seat, a back, sometimes arms."""
    seat, reach, half = rng.uniform(0.42, 0.55), rng.uniform(0.26, 0.34), rng.uniform(0.21, 0.26)
    turns = 2 * np.pi * (np.arange(5) / 5 + rng.random())
    parts = [part(rod([0, 0, 0.1], [reach * np.cos(t), reach * np.sin(t), 0.05], 0.02), PAINT) for t in turns]
    parts += [part(rod([0, 0, 0.08], [0, 0, seat], 0.03), PAINT)]
    parts += [part(cushion([-half, -half, seat], [half, half, seat + 0.08], 0.012), PAINT)]
    back = [-half, 0.21, seat + rng.uniform(0.5, 0.85)]
    parts += [part(cushion([-half - 0.06, -0.21, seat + 0.05], back, 0.009), PAINT)]
    if rng.random() < 0.6:
        for y in (-half - 0.03, half + 0.03):
            parts += [part(slab([0, y, seat + 0.12], [0.28, 0.07, 0.24]), PAINT)]
    return parts


def _door(rng: Rng) -> list[Part]:
    """A leaf in its frame, or a frame alone."""
    wide, high, bar = rng.uniform(0.7, 1.1), rng.uniform(1.9, 2.15), rng.uniform(0.05, 0.12)
    parts = [part(slab([0, side * (wide + bar) / 2, high / 2], [0.06, bar, high]), PAINT) for side in (-1, 1)]
    parts += [part(slab([0, 0, high + bar / 2], [0.06, wide + 2 * bar, bar]), PAINT)]
    if rng.random() < 0.7:
        parts += [part(slab([-0.01, 0, high / 2], [0.04, wide, high]), PAINT)]
        parts += [part(slab([0.04, 0.4 * wide, 1.0], [0.08, 0.12, 0.03]), PAINT)]
    return parts


def _window(rng: Rng) -> list[Part]:
    """A pane in a frame, with a sill at times."""
    wide, high, bar = rng.uniform(0.5, 2.0), rng.uniform(0.6, 1.7), rng.uniform(0.04, 0.1)
    columns = np.linspace(-wide / 2, wide / 2, int(rng.integers(2, 5)))
    parts = [part(slab([0, y, high / 2], [0.07, bar, high]), PAINT) for y in columns]
    parts += [part(slab([0, 0, z], [0.07, wide + bar, bar]), PAINT) for z in (0.0, high)]
    parts += [part(slab([-0.02, 0, high / 2], [0.01, wide, high]), PAINT)]
    if rng.random() < 0.5:
        parts += [part(slab([0.08, 0, -bar / 2], [0.22, wide + 0.15, 0.03]), PAINT)]
    return parts


def _pipes(rng: Rng) -> list[Part]:
    """Pipes side by side, upright or level, with a bend at times."""
    count, radius, long = int(rng.integers(1, 5)), rng.uniform(0.01, 0.12), rng.uniform(0.4, 2.4)
    upright, parts = rng.random() < 0.5, []
    for number in range(count):
        y = number * radius * rng.uniform(2.2, 4.0)
        end = [0, y, long] if upright else [0, long, y]
        start = [0, y, 0] if upright else [0, 0, y]
        parts.append(part(rod(start, end, radius), PAINT))
        if rng.random() < 0.3:
            parts.append(part(rod(end, np.add(end, [rng.uniform(0.1, 0.6), 0, 0]), radius), PAINT))
    return parts


def _tank(rng: Rng) -> list[Part]:
    """A boiler, a heater, a cylinder: a large round or rounded body with stubs."""
    radius, high = rng.uniform(0.15, 0.4), rng.uniform(0.4, 1.8)
    body = (
        lathe([(0, 0), (radius, 0), (radius, 0.9 * high), (0.5 * radius, high), (0, high)])
        if rng.random() < 0.6
        else cushion([-radius, -radius, 0], [radius, radius, high], 0.1 * radius)
    )
    stubs = [(rng.uniform(-0.5, 0.5, 2) * radius, rng.uniform(0.05, 0.5)) for _ in range(int(rng.integers(0, 4)))]
    return [
        part(body, PAINT),
        *(part(rod([*spot, 0.9 * high], [*spot, high + long], 0.02), PAINT) for spot, long in stubs),
    ]


def _stairs(rng: Rng) -> list[Part]:
    """Steps, closed or open below."""
    rise, run, wide = rng.uniform(0.15, 0.2), rng.uniform(0.22, 0.32), rng.uniform(0.6, 1.1)
    thick = rise if rng.random() < 0.5 else 0.04
    return [
        part(slab([run * n, 0, rise * (n + 1) - thick / 2], [run, wide, thick]), PAINT)
        for n in range(int(rng.integers(2, 10)))
    ]


def _body(rng: Rng) -> list[Part]:
    """A box, a wedge or a lump of any proportions."""
    size = np.exp(rng.uniform(np.log(0.05), np.log(1.8), 3))
    kind = rng.integers(3)
    if kind == 0:
        return [part(slab([0, 0, size[2] / 2], size), PAINT)]
    if kind == 1:
        return [part(hull(rng.normal(0, 0.3, (12, 3)) * size), PAINT)]
    return [part(hull(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [0, 1, 1]]) * size), PAINT)]


def _scaffold(rng: Rng) -> list[Part]:
    """Bars in a box: racks, trolleys, clothes horses, ladders, tripods."""
    size = rng.uniform([0.2, 0.3, 0.3], [0.9, 1.4, 1.9])
    corners = rng.uniform(-0.5, 0.5, (int(rng.integers(3, 9)), 2, 3)) * size + [0, 0, size[2] / 2]
    if rng.random() < 0.5:
        corners[:, 1] = corners[:, 0]
        axis = rng.integers(3, size=len(corners))
        corners[np.arange(len(axis)), 1, axis] += size[axis]
    return [part(rod(a, b, rng.uniform(0.008, 0.03)), PAINT) for a, b in corners if np.linalg.norm(a - b) > 0.05]


def _joined(rng: Rng) -> list[Part]:
    """Two to four bodies that touch."""
    parts = _body(rng)
    for _ in range(int(rng.integers(1, 4))):
        more = _body(rng)
        at = rng.uniform(*parts[0].mesh.bounds)
        more[0].mesh.apply_translation(at - more[0].mesh.bounds.mean(axis=0))
        parts += more
    return parts


JUNK: dict[str, Callable[[Rng], list[Part]]] = {
    "office_chair": _office_chair, "a_door": _door, "a_window": _window, "pipes": _pipes, "a_tank": _tank,
    "stairs": _stairs, "a_body": _body, "a_scaffold": _scaffold, "a_joint": _joined,
}  # fmt: skip


ON_WALLS = {"a_door", "a_window"}


def make_junk(kind: str, rng: Rng) -> Solid:
    """A thing of no category."""
    return solid_of(kind, Model(JUNK[kind](rng), placement="wall" if kind in ON_WALLS else "floor"))
