"""From a picture to `objects.json`, step by step (paper 2.1, A.2, A.7), and again with what a person said."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts import InputError, Objects
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import find_category
from roomkin.stages.contracts.errors import first_error
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.matched import Matched
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject, Wall, object_ids
from roomkin.stages.contracts.scenes import Annotation, Held
from roomkin.stages.contracts.types import FLOOR
from roomkin.stages.extraction.contact import DepthView
from roomkin.stages.extraction.corrected_masks import Cutter, correct_masks
from roomkin.stages.extraction.depth_error import NICHE, estimate_depth_error, remove_reflections
from roomkin.stages.extraction.floor import find_floor_frame, find_room_walls
from roomkin.stages.extraction.mounting import MAX_STRETCH, mount_objects
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.extraction.objects import measure_object
from roomkin.stages.geometry.boxes import UprightBox, is_behind, with_bottom
from roomkin.stages.geometry.frames import PointMap, round_vector, yaw_matrix
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
            scene=scene, width=width, height=height, intrinsics=image.intrinsics.tolist(),
            floor_from_camera=view.frame.tolist(), crop=options.crop, depth_error=error, walls=walls,
            objects=[one.object for one in found],
        )  # fmt: skip
    except ValidationError as fault:
        what, fix = f"gives an impossible room: {first_error(fault)}.", "check depth (metres), intrinsics and masks"
        raise InputError("depth.npz", what, fix, code="E-ROOM-BROKEN") from None
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


OBLONG = 1.2  # ratio of two sides, above which one is surely the longer one; chosen
UNLIKE = 5  # times the longest side that is seen, of which more or less is told: borders cut things off; chosen


def reconstruct_corrected(
    image: AnnotatedImage, said: Matched, reconstruct: Callable[[AnnotatedImage], ExtractedScene]
) -> ExtractedScene:
    """The objects of a picture as a person corrected them."""
    lost = list(said.lines)
    print("".join(f"{line}\n" for line in lost), end="")
    if not said.corrections:
        scene = reconstruct(image)
    else:
        corrected, notes = correct_image(image, said.corrections)
        scene, lost = correct_scene(reconstruct(corrected), said.corrections), [*lost, *notes]
    return replace(scene, objects=scene.objects.model_copy(update={"lost": lost}))


def correct_image(image: AnnotatedImage, stated: dict[int, Correction]) -> tuple[AnnotatedImage, list[str]]:
    """The picture with corrected masks, labels, counts and mountings, and what is lost by them, a line each.

    Raises:
        InputError: nothing is left.
    """
    annotations, masks, notes = correct_masks(image.annotations, image.masks, stated, Cutter(image.rgb))
    for note in notes:
        print(note)
    if annotations is None:
        raise InputError("corrections.json", "leaves no object.", "take back that one is gone", code="E-SCENE-EMPTY")
    return replace(image, annotations=annotations, masks=masks), notes


def correct_scene(scene: ExtractedScene, stated: dict[int, Correction]) -> ExtractedScene:
    """The objects with corrected sizes, supports and fronts, in the place of the measured ones."""
    objects, clouds = scene.objects, dict(scene.clouds)
    by_mask = {item.mask: item for item in objects.objects if item.status == "ok"}
    done: dict[int, SceneObject] = {}

    def correct_object(mask: int) -> SceneObject:
        """One object with its corrections; its support was corrected before it."""
        if mask not in done:
            item, given = by_mask[mask], stated.get(mask, Correction(mask=mask))
            carrier = correct_object(given.on) if isinstance(given.on, int) and given.on in by_mask else None
            if given.on == FLOOR:
                item, clouds[item.id] = _put_on(item, clouds[item.id], FLOOR, 0.0)
            elif carrier is not None:
                before = _top_of(by_mask[carrier.mask])
                level = scene.levels.get(carrier.id, before) + _top_of(carrier) - before
                item, clouds[item.id] = _put_on(item, clouds[item.id], carrier.id, level)
            if given.front is not None:
                item = item.model_copy(update={"front": given.front})
            if given.size is not None:
                _tell_unlike(item, given.size)
                item = _resize(item, given.size, objects)
            is_stated = {"mounting": isinstance(given.mounting, Held) and not item.note, "size": given.size is not None}
            done[mask] = item.model_copy(update={"told": [name for name in is_stated if is_stated[name]]})
        return done[mask]

    items = [correct_object(item.mask) if item.status == "ok" else item for item in objects.objects]
    return replace(scene, objects=objects.model_copy(update={"objects": items}), clouds=clouds)


def _top_of(item: SceneObject) -> float:
    """Height at which an object's box ends."""
    assert item.box is not None
    return item.box.center[2] + item.box.size[2] / 2


def _put_on(
    item: SceneObject, cloud: NDArray[np.float32], carrier: str, level: float
) -> tuple[SceneObject, NDArray[np.float32]]:
    """An object and its cloud (N, 3), put on what carries it at a height; one that hung now stands.

    Its own height is what its cloud shows: its box may reach down to what was taken to carry it.
    """
    assert item.box is not None and item.mounting is not None
    box = UprightBox(item.box.center, item.box.size, item.box.yaw)
    bottom = max(box.bottom, float(cloud[:, 2].min()))
    seen = box.top - bottom
    lift = 0.0 if seen / MAX_STRETCH <= box.top - level <= MAX_STRETCH * seen else level - bottom
    up = np.array([0, 0, lift])
    box = with_bottom(replace(box, center=box.center + up), level)
    cloud = (cloud + up).astype(np.float32)
    cloud[:, 2] = np.maximum(cloud[:, 2], np.float32(level))
    mounting = Mounting(type=3, walls=item.mounting.walls) if item.mounting.type == 1 else item.mounting
    return item.model_copy(update={"box": _write_box(box), "mounting": mounting, "support": carrier}), cloud


def _tell_unlike(item: SceneObject, size: tuple[float, float, float]) -> None:
    """Print a line about a stated size that is far from what is seen."""
    assert item.box is not None
    seen = max(item.box.size)
    if not seen / UNLIKE <= max(size) <= UNLIKE * seen:
        stated = " x ".join(f"{side:g}" for side in size)
        print(f"{item.id}: {stated} m are stated of it, and {seen:.2g} m of it are seen: were metres meant?")


def _resize(item: SceneObject, size: tuple[float, float, float], objects: Objects) -> SceneObject:
    """An object with a stated width, depth and height.

    Which of its level axes is the depth: the one along its stated front, or along the normal of its wall; else its
    longer side stays the longer one; else the one along the line of sight.

    What stays in place: the bottom, or the middle of what hangs; the rear at a wall, else the side that faces the
    camera; where the picture's border cuts the object off, the end that is seen.
    """
    assert item.box is not None and item.mounting is not None
    center, turn = np.array(item.box.center), yaw_matrix(item.box.yaw)
    wall = next((one for one in objects.walls if one.id in item.mounting.walls[:1]), None)
    to_camera = np.array(objects.floor_from_camera)[:3, 3] - center
    seen_from = to_camera if wall is None else np.asarray(wall.normal)
    front = seen_from if item.front is None else yaw_matrix(item.front)[:, 0]
    width, depth, height = size
    deep = int(np.argmax(np.abs((turn.T @ front)[:2])))
    if wall is None and item.front is None and _is_oblong(item.box.size[:2]) and _is_oblong((width, depth)):
        deep = int((item.box.size[0] > item.box.size[1]) == (width > depth))
    new = np.array([depth, width, height] if deep == 0 else [width, depth, height])
    right, up = _find_ends_shown(item, objects)
    less = (np.array(item.box.size) - new) / 2
    center[2] -= less[2] * (up if item.mounting.type == 1 else 1)
    center += turn @ (np.sign(turn.T @ seen_from) * less * _main_axis(turn.T @ seen_from))
    to_right = turn.T @ np.array(objects.floor_from_camera)[:3, 0] * right
    center += turn @ (np.sign(to_right) * less * _main_axis(to_right) * (1 - _main_axis(turn.T @ seen_from)))
    if wall is not None:
        center += seen_from * (wall.offset + float(np.abs(turn.T @ seen_from) @ new) / 2 - center @ seen_from)
    box = UprightBox(center, new, item.box.yaw)
    return item.model_copy(update={"box": _write_box(box), "whole": True})


def _find_ends_shown(item: SceneObject, objects: Objects) -> tuple[int, int]:
    """Which ends are seen of an object that the picture's border cuts off: 1 the right (lower) one, -1 the left (upper)
    one, 0 both or none."""
    x0, y0, x1, y1 = item.pixels or (1, 1, 1, 1)
    return int(x0 == 0) - int(x1 == objects.width), int(y0 == 0) - int(y1 == objects.height)


def _is_oblong(extents: Sequence[float]) -> bool:
    """Whether one of two extents is clearly the longer one."""
    return max(extents) > OBLONG * min(extents)


def _main_axis(along: NDArray[np.float64]) -> NDArray[np.float64]:
    """1 for the level axis along which a direction (3,) points most, 0 for the others."""
    return np.asarray(np.arange(3) == np.argmax(np.abs(along[:2])), dtype=float)


def _write_box(box: UprightBox) -> Box:
    return Box(center=round_vector(box.center), size=round_vector(box.size), yaw=round(box.yaw, 6))
