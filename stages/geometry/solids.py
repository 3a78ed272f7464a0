"""Solids: mass and inertia of links whose files state none, as if they were made of boards; outermost points."""

from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError
from trimesh import Trimesh

DENSITY = 500.0  # kg / m^3, of wood; chosen
BOARD = 0.018  # metres: a usual board of furniture
MINIMUM_MASS, MINIMUM_INERTIA = 0.01, 1e-7  # kg, kg m^2, for stable simulation; chosen
Matrix = NDArray[np.float64]


class HasMesh(Protocol):
    """Something that is seen as a mesh."""

    @property
    def mesh(self) -> Trimesh:
        """Its mesh."""
        ...


def board_mass(pieces: Sequence[Trimesh], visuals: Iterable[HasMesh]) -> float:
    """The mass of a link whose file states none: furniture is made of boards.

    It is that of boards with half the visible area (both sides are visible), or of its hulls if that is less.
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
