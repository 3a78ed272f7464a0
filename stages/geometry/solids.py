"""Solids: mass and inertia as of boards, outermost points, and points on and in meshes, always the same."""

from collections.abc import Iterable, Sequence
from functools import cache, lru_cache
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError
from trimesh import Trimesh

DENSITY = 500.0  # kg / m^3, of wood; chosen
BOARD = 0.018  # metres: a usual board of furniture
MINIMUM_MASS, MINIMUM_INERTIA = 0.01, 1e-7  # kg, kg m^2, for stable simulation; chosen
Matrix = NDArray[np.float64]


def board_mass(pieces: Sequence[Trimesh], visuals: Iterable[Any]) -> float:
    """The mass of a link whose file states none: furniture is made of boards.

    It is that of boards with half the area of `visuals` (their `mesh`: both sides are visible), or of its hulls if that
    is less.
    """
    area = sum(float(visual.mesh.area) for visual in visuals)
    volume = min(sum(abs(piece.volume) for piece in pieces), area / 2 * BOARD)
    return max(volume * DENSITY, MINIMUM_MASS)


def box_inertia(pieces: Sequence[Trimesh], mass: float) -> Matrix:
    """Inertia (3, 3) of a solid box around the pieces."""
    low, high = box_around(pieces)
    x, y, z = (high - low) ** 2
    return mass / 12 * np.diag([y + z, x + z, x + y]) + MINIMUM_INERTIA * np.eye(3)


def find_outermost(points: Matrix) -> Matrix:
    """The points (N, 3) that every outline is made of; all of them if they lie in a plane."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points


def box_around(pieces: Sequence[Trimesh]) -> Matrix:
    """Lowest and highest corner (2, 3) of the pieces; a box of one centimetre at the origin if there are none."""
    if not pieces:
        return np.array([[-0.005] * 3, [0.005] * 3])
    corners = np.array([piece.bounds for piece in pieces])
    return np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])


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
