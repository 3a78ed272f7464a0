"""From an observation to `objects.json`: the steps that do not depend on where depth and masks came from."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from stages.config.extraction import ExtractionConfig
from stages.contracts import InputError, Objects
from stages.contracts.files import first_error
from stages.contracts.objects import Box, DepthError, Mounting, SceneObject, Wall, object_ids
from stages.contracts.scenes import Annotation
from stages.contracts.types import LARGEST
from stages.extraction import masks, room
from stages.extraction.border import continued_depth
from stages.extraction.clouds import MAX_POINTS, cleaned_cloud, fit_box, with_top
from stages.extraction.floor import check_smooth, frame_of
from stages.extraction.levels import carrying_heights, ending_near, is_seat, is_topped, level_of
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

THINNEST = 0.001  # metres: a box has some depth, also where a cloud has none


@dataclass(frozen=True)
class ExtractedScene:
    """`objects` and the arrays written beside it (see the contract); by id, the height at which each carries others."""

    objects: Objects
    masks: NDArray[np.uint16]
    depth: NDArray[np.float32]
    clouds: dict[str, NDArray[np.float32]]
    levels: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """An object and what was said of it; if it did not fail its pixels (H, W), cloud (N, 3), box, and the heights at
    which it may carry others."""

    object: SceneObject
    said: Annotation
    mask: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    cloud: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    box: UprightBox | None = None
    heights: tuple[float, ...] = ()


class ObjectError(Exception):
    """One object cannot be used; the scene goes on without it."""


def reconstruct(
    scene: str, image: AnnotatedImage, options: ExtractionConfig, rng: np.random.Generator
) -> ExtractedScene:
    """Floor frame, walls, and per object cloud, box and mounting.

    Raises:
        InputError: depth is noise, no floor can be found, or no room comes out. Anything wrong with one object only
            marks that object as failed.
    """
    check_smooth(image.depth)
    crop = masks.central_crop(image.depth.shape, options.crop)
    usable = crop & (image.depth > 0)
    camera_points = back_project(image.depth, image.intrinsics)
    floor_from_camera = frame_of(camera_points, image, usable, options, rng)
    points = np.where(usable[..., None], apply(floor_from_camera, camera_points), np.nan)
    walls, fitted = _walls(points, image, usable, float(floor_from_camera[2, 3]), options, rng)
    by_id = {wall.id: wall for wall in walls}
    shown = {value: by_id[name] for value, name in fitted.items()}
    error = error_of(image, points, floor_from_camera[:3, 3], shown, options)
    annotations = sorted(image.annotations.objects, key=lambda item: item.mask)
    things = (image.masks == item.mask for item in annotations)
    image = replace(image, depth=without_reflections(image.depth, points, things, walls, error))

    found = [
        _found(name, item, image, crop, floor_from_camera, error, options, rng)
        for name, item in zip(object_ids([item.label for item in annotations]), annotations, strict=True)
    ]
    view = DepthView(np.where(usable, image.depth, 0), image.intrinsics, floor_from_camera, error)
    found = _held(scene, found, image, walls, fitted, view, options)
    height, width = image.depth.shape
    clean = np.zeros((height, width), dtype=np.uint16)
    for one in found:
        if one.box is not None:
            clean[one.mask] = one.object.mask
    try:
        objects = Objects(
            scene=scene,
            width=width,
            height=height,
            intrinsics=image.intrinsics.tolist(),
            floor_from_camera=floor_from_camera.tolist(),
            depth_error=error,
            walls=walls,
            objects=[one.object for one in found],
        )
    except ValidationError as fault:
        what = f"gives a room that cannot be: {first_error(fault)}."
        raise InputError(
            "depth.npz", what, "check depth (metres), intrinsics and masks", code="E-ROOM-BROKEN"
        ) from None
    clouds = {one.object.id: one.cloud.astype(np.float32) for one in found if one.box is not None}
    levels = {one.object.id: one.heights[0] for one in found if one.heights}
    return ExtractedScene(objects, clean, image.depth, clouds, levels)


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


def _found(
    name: str,
    item: Annotation,
    image: AnnotatedImage,
    crop: NDArray[np.bool_],
    floor_from_camera: NDArray[np.float64],
    error: DepthError,
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> Found:
    """One object's pixels, cloud and box."""
    whole = item.box is not None and not item.guessed
    known = SceneObject(id=name, whole=whole, **item.model_dump(exclude={"box", "guessed", "mounting"}))
    share, heights = None, tuple[float, ...]()
    try:
        mask = _object_mask(item, image, crop, options)
        if item.box is not None:
            box = UprightBox(item.box.center, item.box.size, item.box.yaw)
            cloud = surface_points(box, MAX_POINTS)
            cloud = cloud if item.front is not None else rounded_off(cloud, box)
        else:
            share = round(float((image.depth[mask] > 0).mean()), 3)
            cloud = _object_cloud(mask, image, floor_from_camera, options, rng)
            box, heights = _fitted(item.label, cloud, mask, image, floor_from_camera, error, options)
        extent = float(np.max(box.size))
        if extent > LARGEST:
            raise ObjectError(f"{extent:.0f} m large: its depth cannot be right")
    except ObjectError as failure:
        return Found(known.model_copy(update={"status": "failed", "reason": str(failure)}), item)
    seen = {"pixels": pixel_bounds(mask), "points": len(cloud), "depth_known": share}
    return Found(known.model_copy(update=seen), item, mask, cloud, box, heights or (box.top,))


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
    label: str,
    cloud: NDArray[np.float64],
    mask: NDArray[np.bool_],
    image: AnnotatedImage,
    floor_from_camera: NDArray[np.float64],
    error: DepthError,
    options: ExtractionConfig,
) -> tuple[UprightBox, tuple[float, ...]]:
    """The box of a cleaned cloud, and the heights at which it may carry others. What has a level top ends there; what
    lost its thin top to erosion has it again."""
    box = fit_box(cloud, options)
    distance = float(np.linalg.norm(box.center - floor_from_camera[:3, 3]))
    depth = np.where(mask, image.depth, 0.0)
    whole = apply(floor_from_camera, back_project(depth, image.intrinsics)[depth > 0])
    top = float(np.quantile(whole[:, 2], 1 - options.trim))
    lost = top > box.top + options.tolerance(error.at(distance))
    level = level_of(whole if lost else cloud, box, distance)
    box = with_top(box, top) if lost else box
    heights = carrying_heights(label, level, box.top)
    return (box if level is None or not is_topped(label) else with_top(box, level)), heights


def _held(
    scene: str,
    found: list[Found],
    image: AnnotatedImage,
    walls: list[Wall],
    fitted: dict[int, str],
    view: DepthView,
    options: ExtractionConfig,
) -> list[Found]:
    """The objects with their mountings and supports, and boxes down to these; what carries comes before the carried."""
    boxes = {one.object.id: one.box for one in found if one.box is not None}
    unnamed = ~np.isin(image.masks, image.annotations.values)
    carriers: dict[str, UprightBox] = {}
    done = {one.object.id: one for one in found}
    for name in sorted(boxes, key=lambda key: boxes[key].bottom):
        one, box = done[name], boxes[name]
        others = [other for key, other in boxes.items() if key != name]
        own = image.masks == one.object.mask
        stated, note = _stated(one.said, box, walls, fitted, options)
        if note:
            print(f"{scene} {name}: {note}: mounting by geometry")
        told = one.said.box is not None
        seat = is_seat(one.said.label)
        reach = 2 * options.tolerance(view.noise(box.center))
        beneath = {key: ending_near(each, done[key].heights, box.bottom, reach) for key, each in carriers.items()}
        placed = placement(box, beneath, others, walls, view, own, options, told, stated, seat, unnamed)
        if collapsed(box, placed, options.tolerance(view.noise(box.center))):
            reason = "its top is found below what carries it: the depth of one of the two is wrong"
            failed = {"status": "failed", "reason": reason, "points": 0}
            done[name] = Found(one.object.model_copy(update=failed), one.said)
            continue
        carriers[name] = placed.filled
        final = placed.box
        size = rounded(np.maximum(final.size, THINNEST))
        update = {
            "box": Box(center=rounded(final.center), size=size, yaw=round(final.yaw, 6)),
            "mounting": placed.mounting,
            "measured_support": placed.support,
            "measured_mounting": placed.measured if stated else None,
            "note": note,
        }
        done[name] = replace(one, object=one.object.model_copy(update=update))
    return list(done.values())


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
