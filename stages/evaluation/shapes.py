"""Similarity of two models in shape and in doors, drawers and handles, whatever their size."""

from collections import Counter
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from roomkin.stages.articulated.asset_folder import read_asset, read_model
from roomkin.stages.articulated.forward_kinematics import link_frames
from roomkin.stages.contracts import Asset
from roomkin.stages.contracts.library import Vector
from roomkin.stages.contracts.parts import PARTS

CHAMFER_POINTS = 4000  # on each surface; chosen for time
DENSE = 60_000  # on each surface, for its volume; chosen
GRID_CELLS = 24  # per side of the box; chosen


class Likeness(NamedTuple):
    """Distance of the surfaces over the box's diagonal, IoU of what is filled; None where there are no panels."""

    chamfer: float
    shape_iou: float
    panels_correct: bool | None
    handle_correct: bool | None
    hinge_correct: bool | None


@lru_cache(maxsize=256)
def measure_likeness(true: Path, chosen: Path) -> Likeness:
    """Of two asset folders, the chosen one stretched into the box of the true one, all joints closed."""
    if true == chosen:
        opens = True if read_asset(true).articulated else None
        return Likeness(0.0, 1.0, opens, opens, opens)
    a, b = read_asset(true), read_asset(chosen)
    return Likeness(*_shapes(true, chosen, a.size), *_affordances(a, b))


def _shapes(true: Path, chosen: Path, size: Vector) -> tuple[float, float]:
    extents = np.asarray(size)
    ours, theirs = (sample_surface(folder) * extents for folder in (true, chosen))
    a, b = (points[:: DENSE // CHAMFER_POINTS] for points in (ours, theirs))
    distances = np.concatenate([cKDTree(b).query(a)[0], cKDTree(a).query(b)[0]])
    full, other = (fill_cells(points / extents) for points in (ours, theirs))
    chamfer = float(distances.mean() / np.linalg.norm(extents))
    return chamfer, float((full & other).sum() / max(1, (full | other).sum()))


@lru_cache(maxsize=256)
def sample_surface(folder: Path) -> NDArray[np.float64]:
    """Points (DENSE, 3) all over the closed model, its box scaled to [0, 1]; the same ones every time."""
    robot = read_model(folder)
    frames = link_frames(robot)
    meshes = [visual.mesh for link in robot.links.values() for visual in link.map_linearly(frames[link.name]).visuals]
    whole = trimesh.util.concatenate([trimesh.Trimesh(mesh.vertices, mesh.faces, process=False) for mesh in meshes])
    points = np.asarray(trimesh.sample.sample_surface(whole, DENSE, seed=0)[0])
    low, high = whole.bounds
    return (points - low) / np.maximum(high - low, 1e-9)


def fill_cells(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Cells of the unit box that hold points, or that lie between such cells along all three axes."""
    cells = np.zeros((GRID_CELLS,) * 3, dtype=bool)
    cells[tuple(np.clip((points * GRID_CELLS).astype(int), 0, GRID_CELLS - 1).T)] = True
    inside = np.ones_like(cells)
    for axis in range(3):
        before = np.maximum.accumulate(cells, axis)
        after = np.flip(np.maximum.accumulate(np.flip(cells, axis), axis), axis)
        inside &= before & after
    return inside


def _affordances(true: Asset, chosen: Asset) -> tuple[bool | None, bool | None, bool | None]:
    if not true.articulated:
        return None, None, None
    panels = (true.doors, true.drawers) == (chosen.doors, chosen.drawers)
    handles = {joint.handle for joint in true.joints} == {joint.handle for joint in chosen.joints}
    return panels, handles, _hinges(true) == _hinges(chosen)


def _hinges(asset: Asset) -> Counter[str | None]:
    turning = (joint for joint in asset.joints if PARTS[joint.part_type].joint == "revolute")
    return Counter(joint.panel.hinge if joint.panel else None for joint in turning)
