"""A model of the library in the unit box: its outermost points, and where on its visible surface points belong."""

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from stages.articulated.asset_folder import read_asset
from stages.generation.models import read_visuals
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import yaw_matrix

Array = NDArray[np.float64]


class Correspondences(NamedTuple):
    """What of a surface belongs to each of N points: points and normals (N, 3) in the unit box."""

    points: Array
    normals: Array


class Solid:
    """The visible surface of a model, every joint closed, scaled so that its box is [-0.5, 0.5]^3."""

    def __init__(self, folder: Path) -> None:
        asset = read_asset(folder)
        meshes = [visual.mesh for visual in read_visuals(folder)]
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

    def find_correspondences(self, eye: Array, points: Array, box: UprightBox) -> Correspondences:
        """Where rays from `eye` (3,) to `points` (N, 3) meet the model when its box is `box`; of points whose rays
        miss it, what of its surface is nearest to them in the unit box.
        """
        turn = yaw_matrix(box.yaw)
        origin, ends = (eye - box.center) @ turn / box.size, (points - box.center) @ turn / box.size
        rays = np.concatenate([np.broadcast_to(origin, ends.shape), ends - origin], axis=1).astype(np.float32)
        hits = self._scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=1)
        far, normals = hits["t_hit"].numpy(), hits["primitive_normals"].numpy().astype(float)
        missed = np.isinf(far)
        found = origin + rays[:, 3:] * np.where(missed, 0.0, far)[:, None]
        if missed.any():
            queries = o3d.core.Tensor.from_numpy(ends[missed].astype(np.float32))
            found[missed] = self._scene.compute_closest_points(queries, nthreads=1)["points"].numpy()
            normals[missed] = (ends - found)[missed] * box.size**2  # in metres along what is between the two
        return Correspondences(found, normals)


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
