"""A model of the library in the unit box: its outermost points, and where rays meet its visible surface."""

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from stages.articulated.asset_folder import read_asset
from stages.generation.models import read_links
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

Array = NDArray[np.float64]


class Hits(NamedTuple):
    """Where rays meet a surface: which rays (M,), and points and normals (M, 3) in the unit box."""

    rays: NDArray[np.intp]
    points: Array
    normals: Array


class Solid:
    """The visible surface of a model, every joint closed, scaled so that its box is [-0.5, 0.5]^3."""

    def __init__(self, folder: Path) -> None:
        asset = read_asset(folder)
        meshes = [visual.mesh for link in read_links(folder) for visual in link.visuals]
        low, size = np.array(asset.box_min), np.maximum(asset.size, 1e-6)
        vertices = [(np.asarray(mesh.vertices) - low) / size - 0.5 for mesh in meshes]
        starts = np.cumsum([0, *map(len, vertices[:-1])])
        faces = [np.asarray(mesh.faces) + start for mesh, start in zip(meshes, starts, strict=True)]
        self.outermost = find_outermost(np.concatenate(vertices))
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self._scene.add_triangles(
            o3d.core.Tensor.from_numpy(np.concatenate(vertices).astype(np.float32)),
            o3d.core.Tensor.from_numpy(np.concatenate(faces).astype(np.uint32)),
        )

    def cast_rays(self, origin: Array, directions: Array, box: UprightBox) -> Hits:
        """Where rays from `origin` (3,) along `directions` (N, 3) meet the model when its box is `box`."""
        turn = yaw_matrix(box.yaw)
        rays = np.empty((len(directions), 6), np.float32)
        rays[:, :3] = (origin - box.center) @ turn / box.size
        rays[:, 3:] = directions @ turn / box.size
        hits = self._scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=1)
        far = hits["t_hit"].numpy()
        met = np.flatnonzero(np.isfinite(far))
        points = rays[met, :3] + rays[met, 3:] * far[met, None]
        return Hits(met, points.astype(float), hits["primitive_normals"].numpy()[met].astype(float))


def find_outermost(points: Array) -> Array:
    """The points (N, 3) that every outline is made of; all of them if they lie in a plane."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points


@lru_cache(maxsize=64)
def read_solid(folder: Path) -> Solid:
    """The solid of a model of the library."""
    return Solid(folder)
