"""One generated scene against the truth, object by object (paper B.1, Table 2): boxes, shapes, doors, handles."""

from collections import Counter
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from roomkin.stages.articulated.asset_folder import read_asset, read_model
from roomkin.stages.articulated.model import link_frames
from roomkin.stages.contracts import Asset, GeneratedScene, Objects, SceneScore, Truth
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.contracts.scenes import TrueObject
from roomkin.stages.contracts.types import Vector
from roomkin.stages.geometry.boxes import UprightBox, axis_aligned_iou, oriented_iou
from roomkin.stages.geometry.frames import angle_difference, invert_transform, transform_points, yaw_of_matrix

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


MEASURED = ["asset", "l2_cm", "orientation_rad", "orientation_paper_rad", "iou", "oriented_iou", "stable"]


def world_from_floor(world_from_camera: ArrayLike, floor_from_camera: ArrayLike) -> NDArray[np.float64]:
    """4x4 transform from the floor frame that extraction found to the room's world frame, through the camera."""
    return np.asarray(world_from_camera, dtype=float) @ invert_transform(floor_from_camera)


def box_in_world(item: PlacedObject, transform: NDArray[np.float64]) -> UprightBox:
    """The placed box in the world; a floor that was found a little tilted moves boxes, but does not tilt them."""
    yaw = item.yaw + yaw_of_matrix(transform[:3, :3])
    return UprightBox(transform_points(transform, item.position), item.size, yaw)


def score_object(
    true: TrueObject, placed: PlacedObject, transform: NDArray[np.float64], folders: Mapping[str, Path]
) -> dict[str, object]:
    """The measured columns of one row."""
    box, truth = box_in_world(placed, transform), UprightBox(true.position, true.size, true.yaw)
    turn = angle_difference(box.yaw, truth.yaw, true.symmetry)
    known = true.asset in folders and placed.asset in folders
    shape = measure_likeness(folders[true.asset], folders[placed.asset])._asdict() if known else {}
    return {
        "status": "ok", "asset": placed.asset, "category_correct": placed.category == true.category,
        "model_correct": placed.asset == true.asset,
        "l2_cm": 100 * float(np.linalg.norm(np.asarray(box.center) - np.asarray(truth.center))),
        "orientation_rad": turn if true.symmetry != "full" else None,
        "orientation_paper_rad": turn if true.symmetry == "none" else None, "iou": axis_aligned_iou(box, truth),
        "oriented_iou": oriented_iou(box, truth), **shape,
    }  # fmt: skip


def read_settling(scene: GeneratedScene, placed: PlacedObject) -> dict[str, object]:
    """The columns of the settling test, if there was one."""
    check = scene.plausibility
    if check is None or not check.seconds:
        return {}
    return {
        "stable": placed.id not in [*check.fallen, *check.held, *check.behind],
        "shift_cm": None if placed.settled_shift is None else 100 * placed.settled_shift,
        "penetration_cm": 100 * check.max_penetration,
    }


def score_scene(
    scene: GeneratedScene, objects: Objects, truth: Truth, folders: Mapping[str, Path] | None = None
) -> list[SceneScore]:
    """One row per true object, in the order of the truth; an object is known by its value in the masks.

    Args:
        folders: asset folders by id, for the likeness of shapes.

    What is not there, or failed, counts as wrong and has no distances.
    """
    transform = world_from_floor(truth.world_from_camera, scene.floor_from_camera)
    by_id = {item.id: item for item in scene.objects}
    id_of = {item.mask: item.id for item in objects.objects}
    rows = []
    for true in truth.objects:
        name = id_of.get(true.mask)
        placed = by_id.get(name) if name else None
        columns: dict[str, object] = dict.fromkeys(MEASURED)
        columns |= {"category_correct": False, "model_correct": False, "status": "failed" if placed else "missed"}
        if placed and placed.status == "ok":
            columns |= score_object(true, placed, transform, folders or {}) | read_settling(scene, placed)
        about = {"scene": scene.scene, "variant": scene.variant, "rank": scene.rank, "scale_m": truth.scale}
        about |= {"object": name or f"mask_{true.mask}", "true_asset": true.asset}
        rows.append(SceneScore.model_validate(about | columns))
    return rows
