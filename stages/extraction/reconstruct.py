"""From a picture to `objects.json`, step by step, wherever its depth and masks came from (paper 2.1, A.2, A.7)."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts import InputError, Objects
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import find_category
from roomkin.stages.contracts.errors import first_error
from roomkin.stages.contracts.objects import Wall, object_ids
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.extraction.contact import DepthView
from roomkin.stages.extraction.depth_error import NICHE, estimate_depth_error, remove_reflections
from roomkin.stages.extraction.floor import find_floor_frame, find_room_walls
from roomkin.stages.extraction.mounting import mount_objects
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.extraction.objects import measure_object
from roomkin.stages.geometry.boxes import UprightBox, is_behind
from roomkin.stages.geometry.cameras import PointMap
from roomkin.stages.geometry.masks import central_crop


@dataclass(frozen=True)
class ExtractedScene:
    """`objects` and the arrays written beside it (see the contract); by id, the height at which each carries others."""

    objects: Objects
    masks: NDArray[np.uint16]
    depth: NDArray[np.float32]
    clouds: dict[str, NDArray[np.float32]]
    levels: dict[str, float] = field(default_factory=dict)


def reconstruct(
    scene: str, image: AnnotatedImage, options: ExtractionConfig, rng: np.random.Generator
) -> ExtractedScene:
    """Floor frame, walls, and per object cloud, box and mounting.

    Raises:
        InputError: depth is noise, no floor can be found, or no room comes out. Anything wrong with one object only
            marks that object as failed.
    """
    crop = central_crop(image.depth.shape, options.crop)
    seen = PointMap(np.where(crop, image.depth, 0), image.intrinsics)
    seen = replace(seen, frame=find_floor_frame(image, seen, options.max_tilt, rng))
    walls, shown = find_room_walls(image, seen, rng)
    error = estimate_depth_error(image, seen, shown)

    annotations = [
        leave_box(item, find_hanging(item, walls, shown))
        for item in sorted(image.annotations.objects, key=lambda item: item.mask)
    ]
    things = ((image.masks == item.mask, find_hanging(item, walls, shown)) for item in annotations)
    image = replace(image, depth=remove_reflections(image.depth, seen, things, walls, error))
    view = DepthView(np.where(crop, image.depth, 0), image.intrinsics, seen.frame, error)
    names = object_ids([item.label for item in annotations])
    found = [
        measure_object(name, item, image.masks == item.mask, view, options, rng)
        for name, item in zip(names, annotations, strict=True)
    ]
    found = mount_objects(scene, found, image, walls, shown, view)

    height, width = image.depth.shape
    clean = np.zeros((height, width), dtype=np.uint16)
    placed = [one for one in found if one.box is not None]
    for one in placed:
        clean[one.mask] = one.object.mask
    try:
        objects = Objects(
            scene=scene,
            width=width,
            height=height,
            intrinsics=image.intrinsics.tolist(),
            floor_from_camera=view.frame.tolist(),
            crop=options.crop,
            depth_error=error,
            walls=walls,
            objects=[one.object for one in found],
        )
    except ValidationError as fault:
        what = f"gives an impossible room: {first_error(fault)}."
        raise InputError(
            "depth.npz", what, "check depth (metres), intrinsics and masks", code="E-ROOM-BROKEN"
        ) from None
    clouds = {one.object.id: one.cloud.astype(np.float32) for one in placed}
    return ExtractedScene(objects, clean, image.depth, clouds, {one.object.id: one.heights[0] for one in placed})


def find_hanging(item: Annotation, walls: list[Wall], shown: Mapping[int, Wall]) -> list[Wall]:
    """The walls at which an object may hang: those that are stated, else all where its category says that it does.

    Args:
        shown: walls by the mask values that show them.
    """
    if item.mounting is not None:
        return [shown[value] for value in item.mounting.walls if value in shown] if item.mounting.type == 1 else []
    category = find_category(item.label, known_categories(), like=True)
    return walls if category is not None and category.places[0] == "wall" else []


def leave_box(item: Annotation, walls: list[Wall]) -> Annotation:
    """The object without its stated box, if that lies far behind a wall at which it hangs: it is measured there."""
    if item.box is None or item.mounting is None:
        return item
    box = UprightBox(item.box.center, item.box.size, item.box.yaw)
    behind = any(is_behind(box, wall.normal, wall.offset - NICHE) for wall in walls)
    return item.model_copy(update={"box": None}) if behind else item
