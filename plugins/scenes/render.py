"""Command `render`: one room -> what a camera sees of it (`input/`) and, apart from it, the truth."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from roomkin.plugins.scenes.chance import draw_room, frame
from roomkin.plugins.scenes.layout import CastRoom, cast, scale_of
from roomkin.plugins.scenes.photograph import AS_IS, photograph, repaint_room
from roomkin.plugins.scenes.recipe import ScenesConfig, read_room, room_files, series
from roomkin.stages.contracts import Annotations, Camera, InputError, Truth, read_options, write_json
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.scene_input import write_scene_input
from roomkin.stages.contracts.scenes import Annotation, TrueObject
from roomkin.stages.geometry.boxes import corners
from roomkin.stages.geometry.frames import MARGIN


def truth_of(cast_room: CastRoom, world_from_camera: np.ndarray) -> Truth:
    """The true places of all items; in masks.png they are in their order from 1, floor and walls come after them."""
    values = {item.name: value for value, item in enumerate(cast_room.room.items, start=1)}
    objects = []
    for name, standing in cast_room.layout.standing.items():
        asset, box = cast_room.assets[name], standing.box
        objects.append(TrueObject(
            mask=values[name], asset=asset.id, category=asset.category, position=tuple(box.center.tolist()),
            yaw=box.yaw, size=tuple(box.size.tolist()), symmetry=asset.symmetry,
            support=str(values.get(standing.support, standing.support)),
        ))  # fmt: skip
    scene, scale = cast_room.room.name, scale_of(np.array([item.position for item in objects]))
    return Truth(scene=scene, scale=scale, world_from_camera=world_from_camera.tolist(), objects=objects)


def annotations_of(cast_room: CastRoom) -> Annotations:
    """The captions of a perfect captioner: labels, doors and drawers, which mask is the floor and which are walls."""
    objects = []
    for value, item in enumerate(cast_room.room.items, start=1):
        asset = cast_room.assets[item.name]
        counts = {"articulated": asset.articulated, "doors": asset.doors, "drawers": asset.drawers}
        objects.append(Annotation(mask=value, label=item.label, **counts))
    floor, walls = len(objects) + 1, len(cast_room.room.walls)
    return Annotations(objects=objects, floor=floor, walls=[floor + 1 + k for k in range(walls)])


def run(
    *,
    library: tuple[Path, ...],
    scene: str,
    out: Path,
    options: str = "{}",
    seed: int = 0,
    room: Path | None = None,
    layout_seed: int | None = None,
    finish_seed: int | None = None,
) -> None:
    """Furnish and photograph one room.

    Args:
        library: indices of the models that play the objects, their archives beside them.
        scene: name of the room, e.g. room_1.
        out: folder; gets input/ and truth.json.
        options: JSON of the config section `scenes`.
        seed: decides which models are used.
        room: YAML file of a room of your own, which draws its models from the whole library; default: ours.
        layout_seed: draw places, camera, colors and models of the room by chance.
        finish_seed: draw finish and size of every model, colors and light by chance.
    """
    config = read_options(ScenesConfig, options)
    if room is None and scene not in room_files():
        known = f"one of {', '.join(room_files())}"
        raise InputError("--scene", f"no room is called '{scene}'.", known, code="E-ROOM-NAME")
    names = [path.stem for path in series()]
    rooms = [read_room(room)] if room else [read_room(path) for path in series()[: names.index(scene) + 1]]
    folders = AssetFolders(*library)
    models, where = {asset: folders.asset(asset) for asset in folders}, library[0].parent
    if layout_seed is None:
        cast_room = cast(rooms, models, seed, where)[scene]
    else:
        cast_room = draw_room(rooms[-1], models, layout_seed, where, config)
    with TemporaryDirectory() as folder:
        appearance = AS_IS
        if finish_seed is not None:
            cast_room, appearance = repaint_room(cast_room, folders, Path(folder), finish_seed)
        points = np.concatenate([corners(standing.box) for standing in cast_room.layout.standing.values()])
        intrinsics, world_from_camera = frame(points, cast_room.room.camera, config.width, config.height, MARGIN)
        picture = photograph(cast_room, folders, intrinsics, world_from_camera, config, seed, appearance)

    camera = Camera(width=config.width, height=config.height, intrinsics=intrinsics.tolist())
    annotations = annotations_of(cast_room)
    write_scene_input(out / "input", picture.rgb, picture.depth, camera, picture.masks, annotations, exact=True)
    truth = truth_of(cast_room, world_from_camera)
    write_json(out / "truth.json", truth)
    print(f"{scene}: {len(truth.objects)} objects, scale {truth.scale:.2f} m")
