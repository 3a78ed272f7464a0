"""The walls of a room: fitted to their masks, and found where nobody named one; parts of one wall are merged (A.3)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stages.contracts.objects import Wall
from stages.extraction.observation import AnnotatedImage
from stages.geometry.masks import erode
from stages.geometry.room_planes import PLANE_THRESHOLD, SAME_DIRECTION, WallPlane, find_walls, fit_wall

SAME_PLACE = 0.15  # metres: walls of one direction that are nearer than that are one; chosen


def find_room_walls(
    image: AnnotatedImage,
    points: NDArray[np.float64],
    usable: NDArray[np.bool_],
    camera_height: float,
    rng: np.random.Generator,
) -> tuple[list[Wall], dict[int, str]]:
    """The walls, and their ids by the mask values that show them.

    Args:
        points: (H, W, 3) of the pixels, floor frame; only those `usable` (H, W) count.
        camera_height: the camera is at (0, 0, camera_height).
    """
    planes, shown = [], []
    others = usable & ~np.isin(image.masks, [item.mask for item in image.annotations.objects])
    others &= image.masks != image.annotations.floor
    for value in image.annotations.walls:
        mask = erode(usable & (image.masks == value))
        plane = fit_wall(points[mask], camera_height, rng)
        if plane is not None:
            planes.append(plane)
            shown.append(value)
            others &= ~(points @ plane.normal - plane.offset < 3 * PLANE_THRESHOLD)
    planes += find_walls(points[usable], others[usable], camera_height, rng.spawn(1)[0])
    walls, ids = merge_walls(planes)
    return walls, dict(zip(shown, ids, strict=False))


def merge_walls(planes: Sequence[WallPlane]) -> tuple[list[Wall], list[str]]:
    """One wall for all planes that are the same, left and right of a cupboard say; and each plane's wall by its id."""
    merged: list[WallPlane] = []
    ids = []
    for plane in planes:
        for k, other in enumerate(merged):
            same_way = plane.normal @ other.normal > np.cos(np.deg2rad(SAME_DIRECTION))
            if same_way and abs(plane.offset - other.offset) < SAME_PLACE:
                total = plane.inliers + other.inliers
                mean = plane.normal * plane.inliers + other.normal * other.inliers
                offset = (plane.offset * plane.inliers + other.offset * other.inliers) / total
                merged[k] = WallPlane(mean / np.linalg.norm(mean), offset, total)
                break
        else:
            k = len(merged)
            merged.append(plane)
        ids.append(f"wall_{k + 1}")
    walls = [
        Wall(id=f"wall_{k}", normal=(float(normal[0]), float(normal[1]), 0.0), offset=float(offset), points=count)
        for k, (normal, offset, count) in enumerate(merged, start=1)
    ]
    return walls, ids
