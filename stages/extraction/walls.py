"""The walls of a room: fitted to their masks, and found where nobody named one; parts of one wall are merged (A.3)."""

from collections.abc import Sequence

import numpy as np

from stages.contracts.objects import Wall
from stages.extraction.observation import AnnotatedImage
from stages.geometry.masks import erode
from stages.geometry.point_map import PointMap
from stages.geometry.room_planes import PLANE_THRESHOLD, SAME_DIRECTION, WallPlane, find_walls, fit_wall

SAME_PLACE = 0.15  # metres: walls of one direction that are nearer than that are one; chosen


def find_room_walls(
    image: AnnotatedImage, seen: PointMap, rng: np.random.Generator
) -> tuple[list[Wall], dict[int, Wall]]:
    """The walls, and by the mask values that show them.

    Args:
        seen: what is used of the picture, floor frame.
    """
    planes, shown, camera_height = [], [], float(seen.eye[2])
    others = seen.known & ~np.isin(image.masks, [item.mask for item in image.annotations.objects])
    others &= image.masks != image.annotations.floor
    for value in image.annotations.walls:
        mask = erode(seen.known & (image.masks == value))
        plane = fit_wall(seen.of(mask), camera_height, rng)
        if plane is not None:
            planes.append(plane)
            shown.append(value)
            others &= ~(seen.points @ plane.normal - plane.offset < 3 * PLANE_THRESHOLD)
    planes += find_walls(seen.of(seen.known), others[seen.known], camera_height, rng.spawn(1)[0])
    walls, places = merge_walls(planes)
    return walls, {value: walls[place] for value, place in zip(shown, places, strict=False)}


def merge_walls(planes: Sequence[WallPlane]) -> tuple[list[Wall], list[int]]:
    """One wall for all planes that are the same, left and right of a cupboard say; and which of them each plane is."""
    merged: list[WallPlane] = []
    places = []
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
        places.append(k)
    walls = [
        Wall(id=f"wall_{k}", normal=(float(normal[0]), float(normal[1]), 0.0), offset=float(offset), points=count)
        for k, (normal, offset, count) in enumerate(merged, start=1)
    ]
    return walls, places
