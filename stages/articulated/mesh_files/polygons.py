"""Triangles of polygons: a fan where the first corner sees all others, else ears are cut."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.frames import ROUNDING

Corners = NDArray[np.float64]
Triangles = NDArray[np.int64]
NEARLY = 1e-9  # of the squared extent: what is smaller faces no side


def triangles_of(corners: Corners) -> Triangles:
    """Triangles (T, 3), as indices into the corners (N, 3) of a polygon that is about flat, in any plane."""
    steps = np.arange(1, len(corners) - 1)
    fan = np.stack([np.zeros_like(steps), steps, steps + 1], axis=1)
    if len(corners) == 3:
        return fan
    centerd = corners - corners.mean(axis=0)
    normal = np.cross(centerd, np.roll(centerd, -1, axis=0)).sum(axis=0)  # Newell's: twice the area
    least = ROUNDING * float(np.ptp(corners, axis=0).max()) ** 2
    if np.linalg.norm(normal) <= least or (_measure_facing_area(corners, fan, normal) >= -least).all():
        return fan
    import mapbox_earcut  # not where models are read that were imported before: they are of triangles

    flat = np.ascontiguousarray(np.delete(centerd, np.argmax(np.abs(normal)), axis=1))
    cut = mapbox_earcut.triangulate_float64(flat, np.array([len(corners)], dtype=np.uint32))
    if not len(cut):
        return fan
    ears = cut.reshape(-1, 3).astype(np.int64)
    return ears if _measure_facing_area(corners, ears, normal).sum() > 0 else ears[:, ::-1]


def split(vertices: Corners, polygons: Iterable[Triangles]) -> tuple[Triangles, Triangles]:
    """Triangles (T, 3) of polygons that index vertices (V, 3), and for each the number (T,) of its polygon."""
    triangles, numbers = [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for number, polygon in enumerate(polygons):
        if len(polygon) >= 3:
            triangles.append(polygon[triangles_of(vertices[polygon])])
            numbers.append(np.full(len(triangles[-1]), number))
    return np.concatenate(triangles), np.concatenate(numbers)


def _measure_facing_area(corners: Corners, triangles: Triangles, normal: Corners) -> NDArray[np.float64]:
    """Twice the area of each triangle as seen along a polygon's normal: negative, it faces the other way."""
    one, two, three = (corners[triangles[:, column]] for column in range(3))
    return np.asarray(np.cross(two - one, three - one) @ (normal / np.linalg.norm(normal)))
