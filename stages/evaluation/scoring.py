"""One generated scene against the truth, object by object (paper B.1, Table 2)."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roomkin.stages.contracts import GeneratedScene, Objects, SceneScore, Truth
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.scenes import TrueObject
from roomkin.stages.evaluation.shapes import measure_likeness
from roomkin.stages.geometry.boxes import UprightBox, axis_aligned_iou, oriented_iou
from roomkin.stages.geometry.frames import angle_difference, invert_transform, transform_points, yaw_of_matrix

MEASURED = ["asset", "l2_cm", "orientation_rad", "orientation_paper_rad", "iou", "oriented_iou", "stable"]


def world_from_floor(world_from_camera: ArrayLike, floor_from_camera: ArrayLike) -> NDArray[np.float64]:
    """4x4 transform from the floor frame that extraction found to the room's world frame, through the camera."""
    return np.asarray(world_from_camera, dtype=float) @ invert_transform(floor_from_camera)


def box_in_world(item: PlacedObject, transform: NDArray[np.float64]) -> UprightBox:
    """The placed box in the world; a floor that was found a little tilted moves boxes, but does not tilt them."""
    return UprightBox(
        transform_points(transform, item.position), item.size, item.yaw + yaw_of_matrix(transform[:3, :3])
    )


def score_object(
    true: TrueObject, placed: PlacedObject, transform: NDArray[np.float64], folders: Mapping[str, Path]
) -> dict[str, object]:
    """The measured columns of one row."""
    box, truth = box_in_world(placed, transform), UprightBox(true.position, true.size, true.yaw)
    turn = angle_difference(box.yaw, truth.yaw, true.symmetry)
    known = true.asset in folders and placed.asset in folders
    shape = measure_likeness(folders[true.asset], folders[placed.asset])._asdict() if known else {}
    return {
        "status": "ok",
        "asset": placed.asset,
        "category_correct": placed.category == true.category,
        "model_correct": placed.asset == true.asset,
        "l2_cm": 100 * float(np.linalg.norm(np.asarray(box.center) - np.asarray(truth.center))),
        "orientation_rad": turn if true.symmetry != "full" else None,
        "orientation_paper_rad": turn if true.symmetry == "none" else None,
        "iou": axis_aligned_iou(box, truth),
        "oriented_iou": oriented_iou(box, truth),
        **shape,
    }


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
        rows.append(
            SceneScore.model_validate(
                {
                    "scene": scene.scene,
                    "variant": scene.variant,
                    "rank": scene.rank,
                    "scale_m": truth.scale,
                    "object": name or f"mask_{true.mask}",
                    "true_asset": true.asset,
                    **columns,
                }
            )
        )
    return rows
