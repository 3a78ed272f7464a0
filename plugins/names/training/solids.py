"""Triangles of things that stand in the rooms: procedural furniture, and what no library has (`junk`)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from plugins.furniture.catalogue import CATEGORIES
from plugins.furniture.model import Model, fit_model, parts_of
from stages.contracts.library import Placement

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
