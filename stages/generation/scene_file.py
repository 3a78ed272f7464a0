"""A generated scene as a file: doubts about its objects, written, read again; its models as other formats want them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from roomkin.stages.articulated.asset_folder import read_asset, read_model
from roomkin.stages.articulated.mesh_writer import ColoredMesh, split_sharp_edges
from roomkin.stages.articulated.model import JointModel, RobotModel, Visual, link_frames
from roomkin.stages.articulated.resizing import resize_asset
from roomkin.stages.contracts import Asset, GeneratedScene, InputError, Objects
from roomkin.stages.contracts.category import CategoryFacts, describe_unusual, find_category
from roomkin.stages.contracts.doubt import Doubt, DoubtKind, sort_by_chance
from roomkin.stages.contracts.errors import ObjectError
from roomkin.stages.contracts.generated import ROOM_LIGHT, Look, PlacedObject, measure_place_sureness, measure_sureness
from roomkin.stages.contracts.objects import Mounting, SceneObject, Wall
from roomkin.stages.contracts.types import UNNAMED
from roomkin.stages.generation.inputs import Inputs
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.settling import Settled
from roomkin.stages.geometry.boxes import UprightBox, depth_behind, is_behind
from roomkin.stages.geometry.frames import round_vector, transform_points
from roomkin.stages.simulation.room import ColoredBlock, make_backdrop

Matrix = NDArray[np.float64]
CAMERA = "input_camera"


@dataclass(frozen=True)
class Body:
    """A model in its place. `folder`: its files at its size; `pose`: world_from_root (4, 4); not `fixed`: is free."""

    id: str
    label: str
    asset: Asset
    folder: Path
    model: RobotModel
    pose: Matrix
    fixed: bool

    @property
    def frames(self) -> dict[str, Matrix]:
        """root_from_link (4, 4) of every link, closed."""
        return link_frames(self.model)

    @property
    def corners(self) -> Matrix:
        """Of the closed box (8, 3), in the world."""
        low, high = self.asset.box_min, self.asset.box_max
        return transform_points(self.pose, np.array(list(product(*zip(low, high, strict=True)))))

    @property
    def moving(self) -> list[JointModel]:
        """Joints that are not fixed."""
        return [joint for joint in self.model.joints if joint.type != "fixed"]


@dataclass(frozen=True)
class ExportedScene:
    """A scene to export. World: the floor frame, z up, metres. `blocks`: floor and walls; `light`: its direction."""

    scene: GeneratedScene
    bodies: list[Body]
    blocks: list[ColoredBlock]
    light: Matrix

    @property
    def world_from_camera(self) -> Matrix:
        """Of the input picture (4, 4), OpenCV axes."""
        return np.array(self.scene.floor_from_camera)


def room_of(generated: GeneratedScene, items: list[Placed], look: Look | None) -> ExportedScene:
    """A scene with the models of its items, which are at their sizes."""
    bodies = [
        Body(one.id, one.label, one.asset, one.folder, read_model(one.folder), one.pose, one.held) for one in items
    ]
    camera = np.array(generated.floor_from_camera)[:3, 3]
    blocks = make_backdrop([item.box for item in items], generated.walls, camera, look)
    return ExportedScene(generated, bodies, blocks, np.array(look.light if look else ROOM_LIGHT))


def surface_of(block: ColoredBlock) -> ColoredMesh:
    """A block of the backdrop, about its own center."""
    generated = split_sharp_edges(Visual(trimesh.creation.box(block.size), flat=True))
    assert generated.normals is not None
    return ColoredMesh(generated.vertices, generated.faces, generated.normals, (*block.color, 1.0))


def doubt_placements(items: list[Placed], inputs: Inputs) -> list[Placed]:
    """The items, each with what may be wrong with it."""
    walls, known, seen = inputs.objects.walls, inputs.categories, {item.id: item for item in inputs.objects.objects}
    moved = {name for name, nudge in inputs.nudges.items() if nudge is not None}
    return [doubt_placement(item, walls, seen[item.id], known, moved=item.id in moved) for item in items]


def doubt_placement(
    item: Placed, walls: list[Wall], seen: SceneObject, known: Mapping[str, CategoryFacts], moved: bool = False
) -> Placed:
    """The item with what may be wrong with it. Sizes that a person says are not doubted, nor places.

    Args:
        seen: the object as extraction found it.
        known: categories by name, as the library knows them.
        moved: whether a person moved it.
    """
    found: list[Doubt] = []
    if item.support == UNNAMED:
        found.append(DoubtKind.UNNAMED.of())
    for wall in walls:
        if is_behind(item.box, wall.normal, wall.offset):
            found.append(DoubtKind.BEYOND_WALL.of(wall=wall.id))
        elif (depth := depth_behind(item.box, wall.normal, wall.offset)) > DoubtKind.BEHIND_WALL.threshold:
            found.append(DoubtKind.BEHIND_WALL.of(depth=100 * depth, wall=wall.id))
    if seen.depth_known is not None and seen.depth_known < DoubtKind.DEPTH_UNKNOWN.threshold:
        found.append(DoubtKind.DEPTH_UNKNOWN.of(share=100 * seen.depth_known))
    if "size" not in seen.told:
        limit = math.log(DoubtKind.UNUSUAL_SIZE.threshold)
        if odd := describe_unusual(find_category(item.label, known), item.size, limit):
            found.append(DoubtKind.UNUSUAL_SIZE.of(what=odd))
        if item.spread and (sure := measure_sureness(item.size, item.spread)) < DoubtKind.SIZE_UNSURE.threshold:
            depth, width, height = (100 * math.expm1(each) for each in item.spread)
            found.append(DoubtKind.SIZE_UNSURE.of(share=100 * sure, depth=depth, width=width, height=height))
    if item.place_spread and not moved:
        sure = measure_place_sureness(item.place_spread)
        if sure < DoubtKind.PLACE_UNSURE.threshold:
            found.append(DoubtKind.PLACE_UNSURE.of(share=100 * sure))
    return replace(item, doubts=(*item.doubts, *found))


def to_contract(
    items: list[Placed], failed: Mapping[str, str], settled: Settled, room: Objects, variant: str, rank: int
) -> GeneratedScene:
    """The contract of one scene; objects in the order of objects.json, failed ones with their reason."""
    placed = {item.id: item for item in items}
    objects = []
    for extracted in room.objects:
        if reason := failed.get(extracted.id):
            objects.append(PlacedObject(id=extracted.id, label=extracted.label, status="failed", reason=reason))
            continue
        item = placed[extracted.id]
        objects.append(PlacedObject(
            id=item.id, label=item.label, asset=item.asset.id, category=item.asset.category,
            position=round_vector(item.center), yaw=round(item.box.yaw, 6), size=round_vector(item.size),
            size_spread=None if item.spread is None else round_vector(item.spread),
            place_spread=None if item.place_spread is None else round(item.place_spread, 6),
            finish=item.finish, support=item.support, mounting=item.mounting, cousin=item.cousin, chosen=item.chosen,
            steps=list(item.steps), doubts=sort_by_chance(list(item.doubts)), moved=round(item.moved, 6),
            settled_shift=settled.shifts[item.id],
        ))  # fmt: skip
    return GeneratedScene(
        scene=room.scene, variant=variant, rank=rank, width=room.width, height=room.height, intrinsics=room.intrinsics,
        floor_from_camera=room.floor_from_camera, walls=room.walls, objects=objects, plausibility=settled.plausibility,
    )  # fmt: skip


def summarise(scene: GeneratedScene, left: list[tuple[str, str]]) -> list[str]:
    """Lines for the log: the scene's, and one for each thing that does not stand as it should."""
    name, check = f"{scene.scene} rank {scene.rank}", scene.plausibility
    placed = [item for item in scene.objects if item.status == "ok"]
    parts = [f"{name}: {len(placed)} placed"]
    if len(placed) < len(scene.objects):
        parts.append(f"{len(scene.objects) - len(placed)} failed")
    if check is None:
        return ["; ".join(parts)]
    parts += ["does NOT stand" if check.wrong else "stands", f"penetration {1000 * check.max_penetration:.1f} mm"]
    lines = [f"{one} {check.how[one]}" for one in check.fallen]
    lines += [f"{one} is held where it was seen: nothing that was named carries it" for one in check.held]
    lines += [f"{one} reaches behind a wall" for one in check.behind]
    lines += [f"{a} and {b} still collide" for a, b in left]
    return ["; ".join(parts), *(f"{name}: {line}" for line in lines)]


def read_items(generated: GeneratedScene, folders: Mapping[str, Path], cache: Path, path: Path) -> list[Placed]:
    """The objects of a scene, with models at their sizes.

    Args:
        folders: of the library's models, by asset id; `cache`: for resized ones.
        path: of the scene, for what is refused.

    Raises:
        InputError: nothing stands in it, or an asset is not in the library.
    """
    items = []
    for item in generated.objects:
        if item.status != "ok":
            continue
        if item.asset not in folders:
            what = f"{item.id} is '{item.asset}', which the library does not have."
            raise ObjectError(path, what, code="E-LIBRARY-ASSET")
        folder = resize_asset(folders[item.asset], item.size, cache, item.finish)
        box, mounting = UprightBox(item.position, item.size, item.yaw), item.mounting or Mounting(type=2)
        items.append(Placed(item.id, item.label, read_asset(folder), folder, box, mounting, item.support))
    if not items:
        raise InputError(path, "has no object that stands in it.", code="E-SCENE-EMPTY")
    return items
