"""Random variants of a room: sampled until the camera, at the least distance, sees every object well."""

import colorsys
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from roomkin.plugins.scenes import recipe
from roomkin.plugins.scenes.layout import ATTEMPTS, CastRoom, arrange, choose_models, templates
from roomkin.plugins.scenes.recipe import ScenesConfig
from roomkin.stages.contracts import Asset, InputError
from roomkin.stages.geometry import frames
from roomkin.stages.geometry.boxes import UprightBox, corners, distances_along

Matrix = NDArray[np.float64]


def _aim_camera(eye: Matrix, points: Matrix, intrinsics: Matrix) -> Matrix:
    """`world_from_camera` at `eye` that has the points' picture in its center."""
    target = points.mean(axis=0)
    for _ in range(8):
        world_from_camera = frames.look_at(eye, target)
        pixels = frames.project(frames.transform_points(frames.invert_transform(world_from_camera), points), intrinsics)
        if not np.isfinite(pixels).all():
            break
        middle = (pixels.min(axis=0) + pixels.max(axis=0)) / 2
        ray = np.linalg.inv(intrinsics) @ [*middle, 1.0]
        target = eye + world_from_camera[:3, :3] @ ray
        if np.abs(middle - intrinsics[:2, 2]).max() < 0.1:
            break
    return world_from_camera


def frame(points: Matrix, stand: recipe.CameraStand, width: int, height: int, margin: float) -> tuple[Matrix, Matrix]:
    """Intrinsics (3, 3) and `world_from_camera` (4, 4) of the nearest place on the stand's line that shows all points.

    Args:
        points: (N, 3) in the room frame, all of which are to be in the picture.
        width, height: of the picture, pixels; margin: share of it left free at each border.
    """
    intrinsics = frames.intrinsics_from_fov(width, height, np.deg2rad(stand.fov))
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    azimuth = np.deg2rad(stand.azimuth)
    line = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])

    def pose(distance: float) -> Matrix:
        return _aim_camera(np.array([middle[0], middle[1], stand.height]) + distance * line, points, intrinsics)

    def measure_excess(distance: float) -> float:
        """By how much of the picture's size the points stick out of the margins."""
        pixels = frames.project(frames.transform_points(frames.invert_transform(pose(distance)), points), intrinsics)
        if not np.isfinite(pixels).all():
            return 10.0
        size = np.array([width - 1, height - 1])
        return float(np.abs(pixels / size - 0.5).max() - (0.5 - margin))

    return intrinsics, pose(float(brentq(measure_excess, a=1.0, b=30.0, xtol=1e-4)))


ALONG, ON_FLOOR, HEIGHT = 0.35, 0.4, 0.12  # metres by which things move at most
TURN = 25.0  # degrees by which free furniture turns at most
ON_TOP = 0.5  # of the free top
AZIMUTH, EYE, FOV = 10.0, 0.2, 5.0  # degrees, metres, degrees
STEP = 4  # pixels between the rays by which is judged what is seen
SEEN, RAYS = 0.45, 8  # share of every box, and rays on it, that the camera must see
MIRRORED: dict[recipe.WallName, recipe.WallName] = {"back": "back", "left": "right", "right": "left"}
Rng = np.random.Generator


def draw_room(
    room: recipe.RoomPlan, models: dict[str, Asset], seed: int, library: Path, options: ScenesConfig
) -> CastRoom:
    """A furnished room like `room`; its models come from the whole library, whatever stands in other rooms.

    Things move the less the more attempts have failed.

    Raises:
        InputError: a category is short, or nothing fits.
    """
    rng = np.random.default_rng(np.random.SeedSequence((seed, zlib.crc32(room.name.encode()))))
    for attempt in range(ATTEMPTS):
        drawn = redraw_recipe(room, rng, 1 - attempt / ATTEMPTS)
        assets = choose_models(drawn, models, templates(models), rng, library)
        layout = arrange(drawn, {name: asset.size for name, asset in assets.items()})
        if layout is None:
            continue
        boxes = [standing.box for standing in layout.standing.values()]
        points = np.concatenate([corners(box) for box in boxes])
        camera = frame(points, drawn.camera, options.width, options.height, frames.MARGIN)
        if are_all_seen(boxes, *camera, options.width, options.height):
            return CastRoom(drawn, layout, assets)
    what = f"{room.name}: no draw of models and places fits."
    raise InputError(library, what, "change the seed", code="E-ROOM-LAYOUT")


def redraw_recipe(room: recipe.RoomPlan, rng: Rng, reach: float = 1.0) -> recipe.RoomPlan:
    """The recipe, perhaps mirrored, with everything moved by up to `reach` of what is allowed."""
    mirror = bool(rng.random() < 0.5)
    items = tuple(_move_item(_mirror_item(item) if mirror else item, rng, reach) for item in room.items)
    stand = room.camera
    camera = recipe.CameraStand(
        azimuth=(-1 if mirror else 1) * stand.azimuth + AZIMUTH * reach * rng.uniform(-1, 1),
        height=stand.height + EYE * rng.uniform(-1, 1),
        fov=stand.fov + FOV * rng.uniform(-1, 1),
    )
    walls = tuple(MIRRORED[wall] for wall in room.walls) if mirror else room.walls
    return room.model_copy(update={"items": items, "camera": camera, "walls": walls, **colors(rng)})


def colors(rng: Rng) -> dict[str, recipe.Color]:
    """Colors of walls and floor."""
    wall = colorsys.hsv_to_rgb(rng.random(), rng.uniform(0.02, 0.25), rng.uniform(0.65, 0.92))
    floor = colorsys.hsv_to_rgb(rng.uniform(0.04, 0.13), rng.uniform(0.15, 0.55), rng.uniform(0.35, 0.75))
    return {"wall_colour": wall, "floor_colour": floor}


def _mirror_item(item: recipe.Item) -> recipe.Item:
    """Left and right exchanged."""
    place, change = item.place, dict[str, Any]()
    if isinstance(place, recipe.Against | recipe.Hung):
        key = "against" if isinstance(place, recipe.Against) else "hung"
        wall = getattr(place, key)
        change = {key: MIRRORED[wall], "along": -place.along if wall == "back" else place.along}
    elif isinstance(place, recipe.Beside):
        change = {"side": "left" if place.side == "right" else "right"}
    elif isinstance(place, recipe.Floor):
        change = {"floor": (place.floor[0], -place.floor[1]), "yaw": -place.yaw}
    else:
        change = {"right": -place.right, "yaw": -place.yaw}
    return item.model_copy(update={"place": place.model_copy(update=change)})


def _move_item(item: recipe.Item, rng: Rng, reach: float) -> recipe.Item:
    a, b, c = (reach * rng.uniform(-1, 1, 3)).tolist()
    place, change = item.place, dict[str, Any]()
    if isinstance(place, recipe.Against):
        change = {"along": place.along + ALONG * a}
    elif isinstance(place, recipe.Hung):
        change = {"along": place.along + ALONG * a, "z": place.z + HEIGHT * b}
    elif isinstance(place, recipe.Floor):
        x, y = place.floor
        change = {"floor": (x + ON_FLOOR * a, y + ON_FLOOR * b), "yaw": place.yaw + TURN * c}
    elif isinstance(place, recipe.On):
        forward, right = np.clip([place.forward + ON_TOP * a, place.right + ON_TOP * b], -1, 1).tolist()
        change = {"forward": forward, "right": right, "yaw": place.yaw + TURN * c}
    return item.model_copy(update={"place": place.model_copy(update=change)})


def are_all_seen(
    boxes: Sequence[UprightBox],
    intrinsics: NDArray[np.float64],
    world_from_camera: NDArray[np.float64],
    width: int,
    height: int,
) -> bool:
    """Whether enough of every box is in front of all others."""
    u, v = np.meshgrid(np.arange(0, width, STEP), np.arange(0, height, STEP))
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], axis=1)
    directions = np.asarray(pixels @ np.linalg.inv(intrinsics).T @ world_from_camera[:3, :3].T, dtype=float)
    distances = np.stack([distances_along(world_from_camera[:3, 3], directions, box) for box in boxes])
    hit = np.isfinite(distances)
    nearest = np.where(hit.any(axis=0), distances.argmin(axis=0), -1)
    front = np.array([(nearest == k).sum() for k in range(len(boxes))])
    return bool((front >= np.maximum(RAYS, SEEN * hit.sum(axis=1))).all())
