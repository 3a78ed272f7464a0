"""Build a cast room in the simulator, as it is or in other colors, light and sizes, and take its picture."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import sapien
from numpy.typing import NDArray

from roomkin.plugins.scenes.chance import colors
from roomkin.plugins.scenes.layout import ATTEMPTS, CastRoom, arrange
from roomkin.plugins.scenes.recipe import RoomPlan, ScenesConfig
from roomkin.stages.articulated.asset_folder import write_asset
from roomkin.stages.articulated.resizing import load_maker, resize_model
from roomkin.stages.contracts import Asset, InputError
from roomkin.stages.contracts.types import Vector
from roomkin.stages.geometry.frames import scale_intrinsics
from roomkin.stages.simulation.loading import load_asset, root_pose
from roomkin.stages.simulation.rendering import RenderCamera, add_block, instance_id, make_scene
from roomkin.stages.simulation.room import THICKNESS

CHANGE, TINT = 0.15, 0.06  # largest relative change of an extent or of all colors, and of one color channel
SALT = 0xF1715
Rng = np.random.Generator


@dataclass(frozen=True)
class Appearance:
    """Folders of a room's models by item name (none: in the library), direction of the key light, channels' gains."""

    folders: dict[str, Path]
    light: tuple[float, float, float] | None = None
    gain: NDArray[np.float64] | None = None


AS_IS = Appearance({})


def repaint_room(cast_room: CastRoom, library: Mapping[str, Path], out: Path, seed: int) -> tuple[CastRoom, Appearance]:
    """The room with models made anew in `out`: other sizes, finishes, walls and light; ids and counts stay.

    `library`: folders of its models, by id. Models without a recipe (a user's) keep their finish.

    Raises:
        InputError: the models fit at no size.
    """
    rng = np.random.default_rng(np.random.SeedSequence((seed, SALT)))
    for _ in range(ATTEMPTS):
        sizes = {name: _stretch_size(asset.size, rng) for name, asset in cast_room.assets.items()}
        layout = arrange(cast_room.room, sizes)
        if layout is not None:
            break
    else:
        what = "its models fit at no other size."
        raise InputError(cast_room.room.name, what, "change the seed", code="E-ROOM-LAYOUT")
    folders = {name: out / name for name in cast_room.assets}
    assets = {
        name: _paint_model(asset, library[asset.id], sizes[name], folders[name], rng)
        for name, asset in cast_room.assets.items()
    }
    room = cast_room.room.model_copy(update=colors(rng))
    light = (-rng.uniform(0.3, 0.8), rng.uniform(-0.7, 0.7), -1.0)
    gain = (1 + CHANGE * rng.uniform(-1, 1)) * (1 + TINT * rng.uniform(-1, 1, 3))
    return replace(cast_room, room=room, layout=layout, assets=assets), Appearance(folders, light, gain)


def _stretch_size(size: Vector, rng: Rng) -> Vector:
    x, y, z = (np.array(size) * (1 + CHANGE * rng.uniform(-1, 1, 3))).tolist()
    return x, y, z


def _paint_model(asset: Asset, home: Path, size: Vector, out: Path, rng: Rng) -> Asset:
    if asset.recipe is not None:
        asset = asset.model_copy(update={"recipe": load_maker().refinish(asset.recipe, rng)})
    robot, about = resize_model(home, asset, size)
    return write_asset(robot, out, about)


PLANK = 0.24  # metres
PLANK_TONE = 0.035  # standard deviation of the planks' brightness
WALL_HEIGHT = 4.5  # metres: above the upper border of the pictures; chosen
AROUND_FURNITURE = 8.0  # metres by which floor and back wall go on beyond the furniture


@dataclass(frozen=True)
class Photograph:
    """rgb (H, W, 3) uint8; depth (H, W) float32 metres, 0: nothing; masks (H, W) uint16: items 1..N, floor, walls."""

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    masks: NDArray[np.uint16]


def _shell(
    scene: sapien.Scene, room: RoomPlan, half_width: float, length: float, seed: int
) -> list[list[sapien.Entity]]:
    """Floor (of planks) and the room's walls, each a list of its blocks."""
    rng = np.random.default_rng(np.random.SeedSequence((seed, zlib.crc32(room.name.encode()))))
    left = -half_width if "left" in room.walls else -half_width - AROUND_FURNITURE
    right = half_width if "right" in room.walls else half_width + AROUND_FURNITURE
    planks = []
    for k, y in enumerate(np.arange(left, right, PLANK)):
        tone = np.clip(np.array(room.floor_colour) * (1 + PLANK_TONE * rng.standard_normal()), 0, 1)
        center, size = (length / 2, y + PLANK / 2, -0.025), (length, PLANK - 0.002, 0.05)
        planks.append(add_block(scene, center, size, tone.tolist(), f"plank_{k}", roughness=0.55))
    middle, width = (left + right) / 2, right - left
    under = add_block(scene, (length / 2, middle, -0.029), (length, width, 0.05), (0.2, 0.15, 0.1), "gaps")
    parts = [[*planks, under]]
    z, t = WALL_HEIGHT / 2, THICKNESS
    shapes = {
        "back": ((-t / 2, middle, z), (t, width + 2 * t, WALL_HEIGHT)),
        "left": ((length / 2, left - t / 2, z), (length, t, WALL_HEIGHT)),
        "right": ((length / 2, right + t / 2, z), (length, t, WALL_HEIGHT)),
    }
    for wall in room.walls:
        center, size = shapes[wall]
        parts.append([add_block(scene, center, size, room.wall_colour, wall)])
    return parts


def furnish(
    scene: sapien.Scene,
    cast_room: CastRoom,
    folders: Mapping[str, Path],
    fixed: bool,
    made: Mapping[str, Path] | None = None,
) -> dict[str, sapien.Entity | sapien.physx.PhysxArticulation]:
    """Load every item at its place.

    Args:
        folders: of the library's models, by id.
        fixed: no item can move; else only what hangs on a wall cannot.
        made: folders of models, by item, that stand in for the library's.
    """
    bodies = {}
    for name, standing in cast_room.layout.standing.items():
        asset = cast_room.assets[name]
        pose = root_pose(asset, standing.box.center.tolist(), standing.box.yaw)
        held = fixed or standing.support == "wall"
        folder = made[name] if made else folders[asset.id]
        bodies[name] = load_asset(scene, folder, pose, held, name)
    return bodies


def photograph(
    cast_room: CastRoom,
    folders: Mapping[str, Path],
    intrinsics: NDArray[np.float64],
    world_from_camera: NDArray[np.float64],
    options: ScenesConfig,
    seed: int,
    appearance: Appearance = AS_IS,
) -> Photograph:
    """The picture of a room from one camera; colors are smoothed by `supersampling`, depth and masks are not."""
    room = cast_room.room
    side = 1.0 if "right" in room.walls and "left" not in room.walls else -1.0  # light comes over the open side
    scene = make_scene(shadows=True, light=appearance.light or (-0.55, 0.5 * side, -1.0))
    length = float(world_from_camera[0, 3]) + 1.0
    shell = _shell(scene, room, cast_room.layout.half_width, length, seed)
    bodies = furnish(scene, cast_room, folders, fixed=True, made=appearance.folders)

    groups = [[instance_id(body)] for body in bodies.values()]
    groups += [[instance_id(entity) for entity in part] for part in shell]
    plain = RenderCamera(scene, intrinsics, options.width, options.height).render(world_from_camera)
    masks = np.zeros(plain.segmentation.shape, dtype=np.uint16)
    for value, ids in enumerate(groups, start=1):
        masks[np.isin(plain.segmentation, ids)] = value

    rgb, n = plain.rgb, options.supersampling
    if n > 1:
        fine = scale_intrinsics(intrinsics, n, n)
        large = RenderCamera(scene, fine, n * options.width, n * options.height).render(world_from_camera).rgb
        rgb = np.asarray(cv2.resize(large, (options.width, options.height), interpolation=cv2.INTER_AREA))
    if appearance.gain is not None:
        rgb = np.clip(rgb * appearance.gain, 0, 255).astype(np.uint8)
    return Photograph(rgb, plain.depth, masks)
