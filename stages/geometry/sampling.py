"""Points on and in triangle meshes, always the same ones, as `trimesh.sample` draws them with one seed."""

from functools import cache, lru_cache

import numpy as np
import trimesh
from numpy.typing import NDArray

Array = NDArray[np.float64]


@cache
def _draws(count: int) -> tuple[Array, Array]:
    """(count,) shares of a surface, and (count, 2) places in a triangle, along two of its sides."""
    random = np.random.default_rng(0).random
    shares, places = random(count), random((count, 2))
    places[places.sum(axis=1) > 1.0] -= 1.0  # into the triangle's half of the parallelogram
    return shares, np.abs(places)


def sample_triangles(triangles: Array, areas: Array, count: int) -> Array:
    """(count, 3) points, evenly spread over triangles (F, 3, 3) of areas (F,)."""
    shares, places = _draws(count)
    summed = np.cumsum(areas)
    corners = triangles[np.searchsorted(summed, shares * summed[-1])]
    first, second, third = corners[:, 0], corners[:, 1], corners[:, 2]
    return np.asarray((second - first) * places[:, :1] + (third - first) * places[:, 1:] + first)


def split_solids(mesh: trimesh.Trimesh) -> list[NDArray[np.int64]]:
    """The closed pieces of a mesh, by the corners of their faces (F, 3); small holes are filled."""
    return _split_faces(mesh.faces.astype(np.int64).tobytes(), len(mesh.vertices))


@lru_cache(256)  # meshes: those of an asset at another scale hang together alike
def _split_faces(faces: bytes, corners: int) -> list[NDArray[np.int64]]:
    """`Trimesh.split`, to which faces alone matter: the places of the corners are any, but the first number of each."""
    places = np.column_stack([np.arange(corners), np.random.default_rng(0).random((corners, 2))])
    mesh = trimesh.Trimesh(places, np.frombuffer(faces, np.int64).reshape(-1, 3), process=False)
    return [piece.triangles[..., 0].astype(np.int64) for piece in mesh.split()]
