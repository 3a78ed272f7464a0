"""The object that Pick and Place move, and its goal: level surfaces that things stand on or lie in, found with rays."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

Array = NDArray[np.float64]

CELL = 0.005  # metres between rays; hits this close in height are one surface; chosen


@dataclass(frozen=True)
class Region:
    """The largest level surface that is seen from above, in the frame of its mesh; metres.

    height: of the surface. origin: (2,) x, y of the first cell's center. room: (X, Y) distance from each cell to the
    nearest one where the surface ends (a wall, an edge); 0 where there is no surface.
    """

    height: float
    origin: Array
    room: Array

    @property
    def low(self) -> Array:
        """(3,) corner of the box around the surface."""
        return np.append(self.origin + CELL * (np.argwhere(self.room > 0).min(axis=0) - 0.5), self.height)

    @property
    def high(self) -> Array:
        """(3,) the opposite corner, at the same height."""
        return np.append(self.origin + CELL * (np.argwhere(self.room > 0).max(axis=0) + 0.5), self.height)

    def places(self, radius: float) -> Array:
        """(N, 3) centers of the cells on which a disc of `radius` lies wholly within the surface."""
        cells = np.argwhere(self.room >= radius + CELL / 2)
        return np.column_stack([self.origin + CELL * cells, np.full(len(cells), self.height)])


def find_level_region(mesh: trimesh.Trimesh) -> Region | None:
    """The largest level surface among the first hits of rays from above; None if nothing is level."""
    low, high = mesh.bounds
    axes = [np.arange(low[i] + CELL / 2, high[i], CELL) for i in (0, 1)]
    origins = np.stack(np.meshgrid(*axes, [high[2] + 0.1], indexing="ij"), axis=-1).reshape(-1, 3)
    directions = np.tile([0.0, 0.0, -1.0], (len(origins), 1))
    hits, rays, _ = mesh.ray.intersects_location(origins, directions, multiple_hits=False)
    if len(hits) == 0:
        return None
    depth = np.full(len(origins), -np.inf)
    depth[rays] = hits[:, 2]
    heights = np.sort(hits[:, 2])
    counts = np.searchsorted(heights, heights + CELL, side="right") - np.arange(len(heights))
    best = int(counts.argmax())
    height = float(np.median(heights[best : best + counts[best]]))
    level = (np.abs(depth - height) <= CELL).reshape(len(axes[0]), len(axes[1]))
    room = CELL * distance_transform_edt(np.pad(level, 1))[1:-1, 1:-1]
    return Region(height, np.array([axes[0][0], axes[1][0]]), room)


def measure_headroom(region: Region, above: trimesh.Trimesh, most: float = 1.0) -> float:
    """Distance in metres from a surface up to the lowest part of a mesh over it, at most `most`."""
    places = region.places(0.0)[::4]
    places[:, 2] += 1e-3
    up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    hits, _, _ = above.ray.intersects_location(places, up, multiple_hits=False)
    return min(most, float(hits[:, 2].min()) - region.height) if len(hits) else most


@dataclass(frozen=True)
class Movable:
    """An object as it stands now; poses (4, 4) in the robot base frame.

    mesh: in its own frame, upright. region: what it is put into, in the frame that `base_from_region` says, which moves
    with a drawer. there: whether the object is where it belongs, in the gripper or not.
    """

    mesh: trimesh.Trimesh
    base_from_object: Array
    region: Region
    base_from_region: Array
    there: bool


@runtime_checkable
class CarryEnv(Protocol):
    """An environment with something to carry."""

    def movable(self) -> Movable:
        """The object that Pick and Place move, in the first environment."""
