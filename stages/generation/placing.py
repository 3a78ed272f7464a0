"""One model in the place of one object: its yaw, its extents, its walls; not yet on its support (paper A.3, A.7).

The paper takes extents as they are measured. Here what the camera could not see comes from the model's own proportions
(`aspect_prior`).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from stages.config.generation import GenerationConfig
from stages.contracts import Asset, read_json
from stages.contracts.cousins import Cousin
from stages.contracts.doubt import Doubt
from stages.contracts.objects import DepthError, Mounting, Wall
from stages.generation.inputs import Inputs, MatchedObject
from stages.generation.models import beyond_front, visual_meshes
from stages.generation.placed import FLOOR, Placed
from stages.generation.pose import yaw_of
from stages.generation.walls import CONTACT, against_wall, out_of_walls
from stages.geometry.boxes import UprightBox, volume
from stages.geometry.estimate import Sight
from stages.geometry.frames import wrap_angle, yaw_matrix

MEASURED, DEEP = "measured along the model's axes", "as deep as it can be"  # names of steps


def place(one: MatchedObject, cousin: Cousin, inputs: Inputs, options: GenerationConfig) -> Placed:
    """A cousin with the object's yaw, extents and position.

    Raises:
        InputError: the library lacks it.
    """
    item, scene, folder = one.object, inputs.objects, inputs.folder(cousin.asset)
    asset = read_json(Asset, folder / "asset.json")
    assert item.box is not None
    box, mounting = UprightBox(item.box.center, item.box.size, item.box.yaw), item.mounting or Mounting(type=2)
    camera = np.array(scene.floor_from_camera)[:3, 3]
    walls = {wall.id: wall for wall in scene.walls}
    touched = [walls[name] for name in mounting.walls if name in walls and mounting.type != 2]  # the dominant one first
    yaw = yaw_of(cousin, box, one.cloud, camera, touched, asset.articulated, options)
    native = options.aspect_prior == "native"
    is_round = native and asset.symmetry == "full"
    reached = touched if reaches_walls(mounting, box, is_round) else []
    sight = Sight(one.cloud.astype(float), camera, (scene.depth_error if native else DepthError(0, 0)).at)
    rank = next((each.rank for each in one.cousins if each.asset == cousin.asset), None)
    support = item.measured_support or FLOOR
    placed = Placed(item.id, item.label, asset, folder, box, mounting, support, cousin=rank)
    if cousin.differs:
        placed = replace(placed, doubts=(Doubt(cause="affordance", what=cousin.differs),))
    if item.whole:
        placed = placed.changed("as the input tells it", told_box(box, yaw, reached, options.min_extent))
    elif is_round and not reached:
        placed = placed.changed(MEASURED, sight.measured(box, sight_yaw(box, camera), options.trim, False))
        if one.bearings:
            placed = placed.changed("as wide as its outline", as_wide_as_seen(placed.box, camera, one.bearings))
        placed = placed.changed(DEEP, replace(round_box(placed.box, options.aspect_range), yaw=yaw))
    else:
        beyond = beyond_front(visual_meshes(folder)) if native else 0.0
        placed = placed.changed(MEASURED, sight.measured(box, yaw, options.trim, native, beyond))
        for wall in reached:
            placed = placed.changed(f"rear to {wall.id}", against_wall(placed.box, wall, options.min_extent))
        if native and reached:
            deep = deep_at_wall(
                placed.box, asset.size, sight, options.aspect_range, reached[0], hangs=placed.wall_mounted
            )
            placed = placed.changed(DEEP, deep)
        elif native:
            placed = placed.changed(DEEP, deep_in_room(placed.box, asset.size, sight, options.aspect_range))
    if not reached:
        placed = placed.changed("out of walls", out_of_walls(placed.box, scene.walls))
    return placed.changed("least extent", replace(placed.box, size=np.maximum(placed.box.size, options.min_extent)))


def reaches_walls(mounting: Mounting, box: UprightBox, is_round: bool) -> bool:
    """Whether a model is extended to the walls that the object touches: not what stands on furniture, nor what is as
    deep as it is wide."""
    return mounting.type != 3 or not (is_round or box.bottom > CONTACT)


def told_box(box: UprightBox, yaw: float, walls: Sequence[Wall], min_extent: float) -> UprightBox:
    """A box that the input tells, with the axes of a model at `yaw`, which run along its own; it ends at the walls."""
    size = box.size.copy()
    if round((yaw - box.yaw) / (np.pi / 2)) % 2:
        size[:2] = size[1::-1]
    box = UprightBox(box.center, np.maximum(size, min_extent), yaw)
    for wall in walls:
        box = min(box, against_wall(box, wall, min_extent), key=volume)
    return box


def sight_yaw(box: UprightBox, camera: ArrayLike) -> float:
    """Yaw whose x axis points away from the camera."""
    away = box.center[:2] - np.asarray(camera, dtype=float)[:2]
    return wrap_angle(float(np.arctan2(away[1], away[0])))


def as_wide_as_seen(box: UprightBox, camera: ArrayLike, bearings: tuple[float, float]) -> UprightBox:
    """The box of a round model, not narrower than its outline: few points lie at the outline, and they are trimmed.

    Args:
        box: measured along `sight_yaw`, so that y is width.
        bearings: level directions between which the object is seen, radians, floor frame.
    """
    center, size = box.center.copy(), box.size.copy()
    to_center = center[:2] - np.asarray(camera, dtype=float)[:2]
    distance, (low, high) = float(np.linalg.norm(to_center)), bearings
    width = 2 * distance * float(np.sin((high - low) / 2))
    if width <= size[1]:
        return box
    size[1] = width
    center[:2] += distance * yaw_matrix((low + high) / 2)[:2, 0] - to_center
    return UprightBox(center, size, box.yaw)


def round_box(box: UprightBox, believable: tuple[float, float]) -> UprightBox:
    """The box of a round model: as deep as it is wide.

    Its width is seen whole; half of its surface is hidden, and noise and mixed pixels at its outline
    stretch the other half along the line of sight.

    Args:
        box: measured along `sight_yaw`, so that x is depth and y is width.
        believable: a depth beyond the second number times the width has points of the background in it.
    """
    depth, width, height = box.size
    center = box.center
    if depth < width or depth > believable[1] * width:
        center = center + (width - depth) / 2 * yaw_matrix(box.yaw)[:, 0]
    return UprightBox(center, [width, width, height], box.yaw)


def deep_in_room(box: UprightBox, native: ArrayLike, sight: Sight, believable: tuple[float, float]) -> UprightBox:
    """The box of what reaches to no wall, with a believable depth unless its own is measured."""
    if sight.sees_top(box):
        return box
    return believable_box(box, native, sight.camera - box.center, believable)


def deep_at_wall(
    box: UprightBox, native: ArrayLike, sight: Sight, believable: tuple[float, float], wall: Wall, hangs: bool
) -> UprightBox:
    """The box of what was extended to a wall, with a believable depth, the model's own if the cloud tells none.

    What stands and is far too deep does not reach the wall: its front was seen, its rear was not.
    """
    normal = np.asarray(wall.normal)
    unknown = sight.is_one_face(normal)
    at_wall = believable_box(box, native, -normal, (1, 1) if unknown else believable)
    if not hangs and not unknown and volume(at_wall) < volume(box):
        return believable_box(box, native, normal, believable)
    return at_wall


def believable_box(
    box: UprightBox, native: ArrayLike, fixed_face: ArrayLike, believable: tuple[float, float]
) -> UprightBox:
    """The box with its depth replaced if it cannot be that of such a model.

    The scale of an axis is its extent over the model's native one. The median of the three scales is
    the model's scale; a depth whose scale is outside `believable` times it gets that scale. Width and
    height are left alone: the picture shows them.

    Args:
        box: measured extents along the model's axes.
        native: extents (3,) of the model as it is in the library.
        fixed_face: direction (2,) to the face that stays where it is: towards the camera, since that
            side was seen, or towards the wall that the object touches. Depth is along it.
    """
    size, native = box.size.copy(), np.asarray(native, dtype=float)
    along = yaw_matrix(box.yaw)[:2, :2].T @ np.asarray(fixed_face, dtype=float)[:2]
    depth = int(np.argmax(np.abs(along)))
    scales = size / native
    scale = float(np.median(scales))
    if believable[0] * scale <= scales[depth] <= believable[1] * scale:
        return box
    growth = scale * native[depth] - size[depth]
    size[depth] += growth
    center = box.center - np.sign(along[depth]) * growth / 2 * yaw_matrix(box.yaw)[:, depth]
    return replace(box, center=center, size=size)
