"""Find the handle of a door or drawer by ray casting (paper A.4)."""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRID = 0.004  # metres between rays
NEAREST = 0.005  # rays that end this close behind the nearest hit make up the mean handle location (official code)
FRONT = 0.015  # the foremost slice that tells the handle's direction and extents
SURFACE_GAP = 0.001  # metres: what is nearer to a surface along a ray belongs to it
PROTRUSION = 0.012  # a handle sticks out at least this far from its panel
WIDEST = 0.07  # across a handle that a gripper of 8 cm closes on


@dataclass(frozen=True)
class Handle:
    """A graspable handle, in the asset frame with all joints closed. The front faces +x; metres.

    position: (3,) center of its foremost surface. axis: (3,) long direction, in the y-z plane.
    protrusion: distance from the panel to the foremost surface. length, width: extents along and across `axis`.
    """

    position: Array
    axis: Array
    protrusion: float
    length: float
    width: float

    @property
    def elongated(self) -> bool:
        """Whether it has a long direction (a bar); a knob has none."""
        return self.length > 2.0 * self.width


def front_hits(mesh: trimesh.Trimesh) -> Array:
    """First hits (N, 3) of rays that fly along -x onto the mesh, on a grid over its y-z extents."""
    low, high = mesh.bounds
    y, z = (np.arange(low[i] + GRID / 2, high[i], GRID) for i in (1, 2))
    origins = np.stack(np.meshgrid([high[0] + 0.1], y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    directions = np.tile([-1.0, 0.0, 0.0], (len(origins), 1))
    hits, _, _ = mesh.ray.intersects_location(origins, directions, multiple_hits=False)
    return np.asarray(hits)


def find_handle(mesh: trimesh.Trimesh) -> Handle | None:
    """The most protruding feature of a closed panel, or None if nothing sticks out of it.

    What is wider than a gripper may be the raised frame of a front: then it is what stands on that, or within it.

    Args:
        mesh: the moving link with everything fixed to it, in the asset frame, closed.
    """
    hits = front_hits(mesh)
    if len(hits) < 10:
        return None
    panel = _panel_depth(hits[:, 0])
    handle = _find_protrusion(hits, panel)
    if handle is None or handle.width <= WIDEST + GRID:
        return handle
    frame = _panel_depth(hits[hits[:, 0] > (panel + handle.position[0]) / 2, 0])
    others = _find_protrusion(hits, frame), _find_protrusion(hits[hits[:, 0] < frame - SURFACE_GAP], panel)
    return next((other for other in others if other is not None and other.width <= WIDEST + GRID), handle)


def _find_protrusion(hits: Array, panel: float) -> Handle | None:
    """The most protruding feature of a panel at x = `panel`, from ray hits (N, 3)."""
    if not len(hits):
        return None
    nearest = hits[:, 0].max()
    protrusion = float(nearest - panel)
    if protrusion < PROTRUSION:
        return None
    position = hits[hits[:, 0] > nearest - NEAREST].mean(axis=0)
    front = hits[hits[:, 0] > nearest - min(FRONT, protrusion / 2)][:, 1:]
    _, directions = np.linalg.eigh(np.cov(front.T) + 1e-12 * np.diag([0.0, 1.0]))
    along = directions[:, 1]
    across = np.array([-along[1], along[0]])
    length, width = (float(np.ptp(front @ direction)) + GRID for direction in (along, across))
    return Handle(np.array([nearest, *position[1:]]), np.array([0.0, *along]), protrusion, length, width)


def exact_width(mesh: trimesh.Trimesh, handle: Handle) -> float:
    """Width of a handle in metres, from its mesh: the grid of rays that found it adds up to 4 mm."""
    depth = handle.position[0] - min(FRONT, handle.protrusion / 2)
    part = trimesh.intersections.slice_mesh_plane(mesh, [1.0, 0.0, 0.0], [depth, 0.0, 0.0])
    along = handle.axis[1:]
    across = np.array([-along[1], along[0]])
    points = np.asarray(part.vertices)[:, 1:] - handle.position[1:]
    its_own = (np.abs(points @ across) <= handle.width) & (np.abs(points @ along) <= handle.length)
    return float(np.ptp(points[its_own] @ across)) if its_own.any() else handle.width


def _panel_depth(x: Array) -> float:
    """The x at which most rays end: the panel covers more area than its frame or its handle."""
    counts, edges = np.histogram(x, bins=max(1, int(np.ceil(np.ptp(x) / NEAREST))))
    best = int(counts.argmax())
    return float(np.median(x[(x >= edges[best]) & (x <= edges[best + 1])]))
