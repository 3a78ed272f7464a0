"""Solid shapes in metres, as watertight trimesh meshes; everything else is put together from these."""

import itertools
from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull
from trimesh import Trimesh

SEGMENTS = 24  # of a full circle
CUBE = trimesh.creation.box()  # of side 1 about the origin


def box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Trimesh:
    """Axis-aligned box between the bounds."""
    low, high = np.sort(np.array([x, y, z], dtype=float), axis=1).T
    return Trimesh((low + high) / 2 + CUBE.vertices * (high - low), CUBE.faces, process=False)


def slab(center: ArrayLike, size: ArrayLike) -> Trimesh:
    """Axis-aligned box by its center and extents."""
    vertices = np.asarray(center, dtype=float) + CUBE.vertices * np.asarray(size, dtype=float)
    return Trimesh(vertices, CUBE.faces, process=False)


def hull(points: ArrayLike) -> Trimesh:
    """Convex hull of points (N, 3)."""
    found = ConvexHull(np.asarray(points, dtype=float), qhull_options="QbB Pp Qt")
    corners = found.points[found.simplices]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside = (outward * found.equations[:, :3]).sum(axis=1) < 0
    faces = np.where(inside[:, None], found.simplices[:, ::-1], found.simplices)
    used = np.sort(found.vertices)
    return Trimesh(found.points[used], np.searchsorted(used, faces), process=False)


def cushion(corner: ArrayLike, opposite: ArrayLike, edge: float) -> Trimesh:
    """Box between two corners whose edges are chamfered by `edge`."""
    low, high = np.sort(np.array([corner, opposite], dtype=float), axis=0)
    edge = min(edge, 0.45 * float((high - low).min()))
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    center, half = (low + high) / 2, (high - low) / 2
    pulled = [half - edge * (1 - np.eye(3)[axis]) for axis in range(3)]
    return hull(np.concatenate([center + corners * h for h in pulled]))


def rod(
    start: ArrayLike, end: ArrayLike, radius: float, end_radius: float | None = None, segments: int = 12
) -> Trimesh:
    """Cylinder, or frustum where `end_radius` differs, from `start` to `end`."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(end - start))
    tip = radius if end_radius is None else end_radius
    mesh = lathe([(0, 0), (radius, 0), (tip, length), (0, length)], segments)
    mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], (end - start) / length))
    mesh.apply_translation(start)
    return mesh


def beam(start: ArrayLike, end: ArrayLike, width: float, end_width: float | None = None) -> Trimesh:
    """Square beam (horizontal cross-sections) between two points; it may lean and taper."""
    square = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]])
    tip = width if end_width is None else end_width
    return hull(np.concatenate([np.asarray(start) + square * width, np.asarray(end) + square * tip]))


def lathe(profile: Sequence[tuple[float, float]], segments: int = SEGMENTS) -> Trimesh:
    """Solid of revolution about z of a closed profile of (radius, z), from axis to axis, bottom first."""
    return trimesh.creation.revolve(np.asarray(profile, dtype=float), sections=segments)


def shell_pieces(
    outer: Sequence[tuple[float, float]], inner: Sequence[tuple[float, float]], pieces: int = 12
) -> list[Trimesh]:
    """Convex pieces of the wall between two profiles of (radius, z) with as many points each: hollow to PhysX.

    Each band between consecutive points becomes `pieces` wedges around the axis.
    """
    solids = []
    edges = 2 * np.pi * np.arange(pieces + 1) / pieces
    for (a, b), (c, d) in zip(itertools.pairwise(outer), itertools.pairwise(inner), strict=True):
        for angles in itertools.pairwise(edges):
            solids.append(hull([(r * np.cos(t), r * np.sin(t), z) for t in angles for r, z in (a, b, c, d)]))
    return solids


def rim(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], width: float) -> list[Trimesh]:
    """Four strips around a rectangle of y and z, inside it."""
    inner = (y[0] + width, y[1] - width)
    sides = [box(x, (y[0], inner[0]), z), box(x, (inner[1], y[1]), z)]
    return [*sides, box(x, inner, (z[0], z[0] + width)), box(x, inner, (z[1] - width, z[1]))]


def make_sides(x: float, y: float, z: tuple[float, float], wall: float) -> list[Trimesh]:
    """The four sides of a box from -x to x and from -y to y: two across x, whole, then two between them."""
    across = [box((s * x, s * (x - wall)), (-y, y), z) for s in (-1, 1)]
    return across + [box((-x + wall, x - wall), (s * y, s * (y - wall)), z) for s in (-1, 1)]


def ball(radius: float, low: float, high: float, bands: int, segments: int = SEGMENTS) -> Trimesh:
    """Ellipsoid about the z axis between two heights."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, bands + 1)
    profile = [(radius * float(np.cos(t)), (low + high) / 2 + (high - low) / 2 * float(np.sin(t))) for t in angles]
    profile[0], profile[-1] = (0.0, low), (0.0, high)
    return lathe(profile, segments)


def translate(mesh: Trimesh, by: ArrayLike) -> Trimesh:
    """A copy moved by a vector."""
    copy = mesh.copy()
    copy.apply_translation(np.asarray(by, dtype=float))
    return copy


def widen(mesh: Trimesh, x: float, y: float) -> Trimesh:
    """The mesh itself, its x and y multiplied in place: a circle of radius 1 becomes an ellipse."""
    mesh.vertices *= [x, y, 1.0]
    return mesh


def rotate(mesh: Trimesh, angle: float, axis: ArrayLike) -> Trimesh:
    """A copy turned by `angle` about an axis through the origin."""
    copy = mesh.copy()
    copy.apply_transform(trimesh.transformations.rotation_matrix(angle, axis))
    return copy


def bounds_of(meshes: Sequence[Trimesh]) -> NDArray[np.float64]:
    """Lowest and highest corner, (2, 3), of several meshes."""
    corners = np.array([mesh.bounds for mesh in meshes])
    return np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])
