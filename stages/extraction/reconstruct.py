"""From an observation to `objects.json`: the steps that do not depend on where depth and masks came from."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stages.config.extraction import ExtractionConfig
from stages.contracts import InputError, Objects
from stages.contracts.objects import Box, DepthError, Mounting, SceneObject, Wall, object_ids
from stages.contracts.scenes import Annotation
from stages.contracts.types import LARGEST
from stages.extraction import masks, room
from stages.extraction.border import continued_depth
from stages.extraction.clouds import cleaned_cloud, fit_box, level_height, with_top
from stages.extraction.mounting import collapsed, placement
from stages.extraction.observation import AnnotatedImage
from stages.extraction.reflections import without_reflections
from stages.extraction.sensor import error_of
from stages.extraction.stated import ImpossibleError, stated_mounting
from stages.extraction.visibility import DepthView
from stages.geometry.boxes import UprightBox, rounded_off, surface_points
from stages.geometry.cameras import back_project
from stages.geometry.frames import apply, rounded
from stages.geometry.masks import pixel_bounds

BOX_POINTS = 4000  # of the cloud of an object whose box is given
THINNEST = 0.001  # metres: a box has some depth, also where a cloud has none


@dataclass(frozen=True)
class ExtractedScene:
    """`objects` and the arrays written beside it (see the contract)."""

    objects: Objects
    masks: NDArray[np.uint16]
    depth: NDArray[np.float32]
    clouds: dict[str, NDArray[np.float32]]


class ObjectError(Exception):
    """One object cannot be used; the scene goes on without it."""


def _object_mask(
    item: Annotation, image: AnnotatedImage, crop: NDArray[np.bool_], options: ExtractionConfig
) -> NDArray[np.bool_]:
    whole = image.masks == item.mask
    if not whole.any():
        raise ObjectError("not in the picture: no pixel has its mask value")
    inside = masks.without_specks(whole & crop)
    if item.box is None and (whole & crop).sum() < (1 - options.max_cut) * whole.sum():
        raise ObjectError("cut off: too much of it is outside the central crop")
    if inside.sum() < options.min_pixels:
        raise ObjectError(f"too small or hidden: {int(inside.sum())} pixels")
    return inside


def _object_cloud(
    mask: NDArray[np.bool_],
    image: AnnotatedImage,
    floor_from_camera: NDArray[np.float64],
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    core = masks.eroded(mask, options.erosion, options.erosion_keep)
    depth = np.where(core, image.depth, 0.0)
    if options.restore_border:
        depth = continued_depth(image.depth, core, mask)
    cloud = apply(floor_from_camera, back_project(depth, image.intrinsics)[depth > 0])
    if len(cloud) < 3:
        raise ObjectError("no depth on its pixels")
    cloud = cleaned_cloud(cloud, options, rng, floor_from_camera[:3, 3])
    if len(cloud) < 3:
        raise ObjectError("its depth is too scattered: no cluster of points")
    return cloud


def _fitted(
    cloud: NDArray[np.float64],
    mask: NDArray[np.bool_],
    image: AnnotatedImage,
    floor_from_camera: NDArray[np.float64],
    error: DepthError,
    options: ExtractionConfig,
) -> UprightBox:
    """The box of a cleaned cloud. What has a level top ends there; what lost its thin top to erosion has it again."""
    box = fit_box(cloud, options)
    distance = float(np.linalg.norm(np.asarray(box.center) - floor_from_camera[:3, 3]))
    noise = error.at(distance)
    depth = np.where(mask, image.depth, 0.0)
    whole = apply(floor_from_camera, back_project(depth, image.intrinsics)[depth > 0])
    level = level_height(cloud, whole, box, noise, distance, options.trim)
    if level is not None:
        return with_top(box, level)
    top = float(np.quantile(whole[:, 2], 1 - options.trim))
    return with_top(box, top) if top > box.top + options.tolerance(noise) else box


def _floor_from_camera(
    points: NDArray[np.float64],
    image: AnnotatedImage,
    usable: NDArray[np.bool_],
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Floor frame as given, from the floor mask, or from the level planes if there is no mask or it is no use."""
    if image.floor_from_camera is not None:
        return image.floor_from_camera
    floor = None
    if image.annotations.floor is not None:
        floor = room.fit_floor(points[usable & (image.masks == image.annotations.floor)], options, rng)
    if floor is None:
        named = [item.mask for item in image.annotations.objects]
        clouds = [cloud for value in named if len(cloud := points[usable & (image.masks == value)])]
        rest = points[usable & ~np.isin(image.masks, [*named, *image.annotations.walls])]
        floor = room.find_floor(rest, clouds, options, rng) or room.find_floor(points[usable], clouds, options, rng)
    if floor is None:
        raise InputError(
            "depth.npz", "shows no level plane that could be the floor.", "check depth (metres) and intrinsics"
        )
    if image.annotations.floor is None:
        what = "the level plane that most objects stand on" if image.annotations.objects else "the lowest level plane"
        print(f"no mask of the floor: taken to be {what}, {-floor.offset:.2f} m below the camera")
    return room.floor_frame(floor)


def _walls(
    points: NDArray[np.float64],
    image: AnnotatedImage,
    usable: NDArray[np.bool_],
    camera_height: float,
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> tuple[list[Wall], dict[int, str]]:
    """The walls, and each one's id by the mask values that show it; what nobody named may show others."""
    fits, shown = [], []
    others = usable & ~np.isin(image.masks, [item.mask for item in image.annotations.objects])
    others &= image.masks != image.annotations.floor
    for value in image.annotations.walls:
        mask = masks.eroded(usable & (image.masks == value), options.erosion, options.erosion_keep)
        fit = room.fit_wall(points[mask], camera_height, options, rng)
        if fit is not None:
            fits.append(fit)
            shown.append(value)
            others &= ~(points @ fit[0] - fit[1] < 3 * options.plane_threshold)
    fits += room.find_walls(points[usable], others[usable], camera_height, options, rng.spawn(1)[0])
    walls, ids = room.merge_walls(fits, options)
    return walls, dict(zip(shown, ids, strict=False))


def _stated(
    item: Annotation, box: UprightBox, walls: list[Wall], fitted: dict[int, str], options: ExtractionConfig
) -> tuple[Mounting | None, str]:
    """How the input says that an object is held, or why that cannot be."""
    if item.mounting is None:
        return None, ""
    try:
        return stated_mounting(item.mounting, box, walls, fitted, options), ""
    except ImpossibleError as error:
        return None, str(error)


def reconstruct(
    scene: str, image: AnnotatedImage, options: ExtractionConfig, rng: np.random.Generator
) -> ExtractedScene:
    """Floor frame, walls, and per object cloud, box and mounting.

    Raises:
        InputError: no floor can be found. Anything wrong with one object only marks that object as failed.
    """
    shape = image.depth.shape
    crop = masks.central_crop(shape, options.crop)
    usable = crop & (image.depth > 0)
    camera_points = back_project(image.depth, image.intrinsics)
    floor_from_camera = _floor_from_camera(camera_points, image, usable, options, rng)
    points = np.where(usable[..., None], apply(floor_from_camera, camera_points), np.nan)
    walls, fitted = _walls(points, image, usable, float(floor_from_camera[2, 3]), options, rng)
    by_id = {wall.id: wall for wall in walls}
    error = error_of(image, points, floor_from_camera[:3, 3], {value: by_id[name] for value, name in fitted.items()})

    annotations = sorted(image.annotations.objects, key=lambda item: item.mask)
    things = (image.masks == item.mask for item in annotations)
    image = replace(image, depth=without_reflections(image.depth, points, things, walls, error))
    extracted: dict[str, SceneObject] = {}
    boxes: dict[str, UprightBox] = {}
    clouds: dict[str, NDArray[np.float32]] = {}
    clean = np.zeros(shape, dtype=np.uint16)
    for name, item in zip(object_ids([item.label for item in annotations]), annotations, strict=True):
        whole = item.box is not None and not item.guessed
        known = SceneObject(id=name, whole=whole, **item.model_dump(exclude={"box", "guessed", "mounting"}))
        try:
            mask = _object_mask(item, image, crop, options)
            if item.box is not None:
                box = UprightBox(item.box.center, item.box.size, item.box.yaw)
                cloud = surface_points(box, BOX_POINTS)
                cloud = cloud if item.front is not None else rounded_off(cloud, box)
            else:
                cloud = _object_cloud(mask, image, floor_from_camera, options, rng)
                box = _fitted(cloud, mask, image, floor_from_camera, error, options)
            extent = float(np.max(box.size))
            if extent > LARGEST:
                raise ObjectError(f"{extent:.0f} m large: its depth cannot be right")
        except ObjectError as failure:
            extracted[name] = known.model_copy(update={"status": "failed", "reason": str(failure)})
            continue
        clean[mask] = item.mask
        clouds[name] = cloud.astype(np.float32)
        boxes[name] = box
        extracted[name] = known.model_copy(update={"pixels": pixel_bounds(mask), "points": len(cloud)})

    view = DepthView(np.where(usable, image.depth, 0), image.intrinsics, floor_from_camera, error)
    given = {item.mask: item for item in annotations}
    unnamed = ~np.isin(image.masks, image.annotations.values)
    carriers: dict[str, UprightBox] = {}
    for name in sorted(boxes, key=lambda key: boxes[key].bottom):  # what carries comes before what it carries
        others = [other for key, other in boxes.items() if key != name]
        own = image.masks == extracted[name].mask
        item = given[extracted[name].mask]
        stated, note = _stated(item, boxes[name], walls, fitted, options)
        if note:
            print(f"{scene} {name}: {note}: mounting by geometry")
        told = item.box is not None
        placed = placement(boxes[name], carriers, others, walls, view, own, options, told, stated, unnamed)
        if collapsed(boxes[name], placed, options.tolerance(view.noise(boxes[name].center))):
            reason = "its top is found below what carries it: the depth of one of the two is wrong"
            extracted[name] = extracted[name].model_copy(update={"status": "failed", "reason": reason, "points": 0})
            clean[clean == extracted[name].mask] = 0
            del clouds[name]
            continue
        carriers[name] = placed.filled
        box = placed.box
        extracted[name] = extracted[name].model_copy(
            update={
                "box": Box(
                    center=rounded(box.center), size=rounded(np.maximum(box.size, THINNEST)), yaw=round(box.yaw, 6)
                ),
                "mounting": placed.mounting,
                "measured_support": placed.support,
                "measured_mounting": placed.measured if stated else None,
                "note": note,
            }
        )
    objects = Objects(
        scene=scene,
        width=shape[1],
        height=shape[0],
        intrinsics=image.intrinsics.tolist(),
        floor_from_camera=floor_from_camera.tolist(),
        depth_error=error,
        walls=walls,
        objects=list(extracted.values()),
    )
    return ExtractedScene(objects, clean, image.depth, clouds)
