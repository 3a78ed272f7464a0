"""The walls of a room: fitted to their masks, and found where nobody named one; parts of one wall are merged (A.3)."""

import numpy as np

from roomkin.stages.contracts.objects import Wall
from roomkin.stages.extraction.observation import AnnotatedImage
from roomkin.stages.geometry.cameras import PointMap
from roomkin.stages.geometry.masks import erode
from roomkin.stages.geometry.room_planes import PLANE_THRESHOLD, find_walls, fit_wall, merge_walls


def find_room_walls(
    image: AnnotatedImage, seen: PointMap, rng: np.random.Generator
) -> tuple[list[Wall], dict[int, Wall]]:
    """The walls, and by the mask values that show them.

    Args:
        seen: what is used of the picture, floor frame.
    """
    planes, shown, camera_height = [], [], float(seen.frame[2, 3])
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
    merged, places = merge_walls(planes)
    walls = [
        Wall(id=f"wall_{k}", normal=(float(normal[0]), float(normal[1]), 0.0), offset=float(offset), points=count)
        for k, (normal, offset, count) in enumerate(merged, start=1)
    ]
    return walls, {value: walls[place] for value, place in zip(shown, places, strict=False)}
