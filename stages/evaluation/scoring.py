"""One generated scene against the truth, object by object (paper B.1, Table 2)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stages.contracts import GeneratedScene, Objects, SceneScore, Truth
from stages.contracts.generated import PlacedObject
from stages.contracts.scenes import TrueObject
from stages.geometry.boxes import UprightBox, axis_aligned_iou, oriented_iou
from stages.geometry.frames import angle_difference, apply, inverse, yaw_of_matrix


def world_from_floor(world_from_camera: ArrayLike, floor_from_camera: ArrayLike) -> NDArray[np.float64]:
    """4x4 transform from the floor frame that extraction found to the room's world frame, through the camera."""
    return np.asarray(world_from_camera, dtype=float) @ inverse(floor_from_camera)


def box_in_world(item: PlacedObject, transform: NDArray[np.float64]) -> UprightBox:
    """The placed box in the world; a floor that was found a little tilted moves boxes, but does not tilt them."""
    return UprightBox(apply(transform, item.position), item.size, item.yaw + yaw_of_matrix(transform[:3, :3]))


def score_object(
    true: TrueObject, placed: PlacedObject | None, transform: NDArray[np.float64], stable: bool | None
) -> dict[str, object]:
    """The measured columns of one row. What is not there, or failed, counts as wrong and has no distances."""
    if placed is None or placed.status == "failed":
        return {
            "status": "missed" if placed is None else "failed",
            "asset": None,
            "category_correct": False,
            "model_correct": False,
            "l2_cm": None,
            "orientation_rad": None,
            "orientation_paper_rad": None,
            "iou": None,
            "oriented_iou": None,
            "stable": None,
        }
    box, truth = box_in_world(placed, transform), UprightBox(true.position, true.size, true.yaw)
    turn = angle_difference(box.yaw, truth.yaw, true.symmetry)
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
        "stable": stable,
    }


def score_scene(scene: GeneratedScene, objects: Objects, truth: Truth) -> list[SceneScore]:
    """One row per true object, in the order of the truth; an object is known by its value in the masks."""
    transform = world_from_floor(truth.world_from_camera, scene.floor_from_camera)
    by_id = {item.id: item for item in scene.objects}
    id_of = {item.mask: item.id for item in objects.objects}
    check = scene.plausibility
    rows = []
    for true in truth.objects:
        name = id_of.get(true.mask)
        placed = by_id.get(name) if name else None
        stable = None if check is None or not check.seconds else name not in check.fallen
        columns = score_object(true, placed, transform, stable)
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
