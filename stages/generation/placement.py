"""From one matched object to a placed asset, and from all of them to a scene (paper 2.1, A.3, A.7)."""

from collections.abc import Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stages.config.generation import GenerationConfig
from stages.contracts import Asset, Objects
from stages.contracts.cousins import Cousin
from stages.contracts.objects import Box, DepthError, Mounting, SceneObject, Wall
from stages.generation.collisions import out_of_walls
from stages.generation.extents import measured_box, only_noise, top_seen
from stages.generation.mounting import against_wall, on_supports
from stages.generation.placed import Placed
from stages.generation.pose import rear_at_wall, rectangularity, turned_to, wall_axes
from stages.generation.prisms import Prism, Surface, placed_prisms, surface_beneath
from stages.generation.sizing import as_wide_as_seen, believable_box, round_box, sight_yaw, told_box
from stages.generation.steps import Change, changed, told
from stages.generation.support import carried, sorted_by_height, support_tree
from stages.geometry.boxes import UprightBox, volume
from stages.geometry.viewing import view_yaw

ON_FURNITURE = 0.05  # metres above the floor


def walls_of(mounting: Mounting, walls: list[Wall]) -> list[Wall]:
    """The walls that an object touches, the dominant one first."""
    by_id = {wall.id: wall for wall in walls}
    return [by_id[name] for name in mounting.walls if name in by_id] if mounting.type != 2 else []


def matched_yaw(
    cousin: Cousin, extracted: UprightBox, camera: NDArray[np.float64], touched: list[Wall], options: GenerationConfig
) -> float:
    """Yaw of the matched view, or of the best of the k_ori views that turns its rear to a touched wall."""
    views = [cousin.orientation, *cousin.orientations]
    yaws = [view_yaw(camera, extracted.center, view.yaw) for view in views]
    return rear_at_wall(yaws, [wall.normal for wall in touched]) if options.wall_view == "rear" else yaws[0]


def final_yaw(
    yaw: float,
    box: Box,
    cloud: NDArray[np.floating],
    touched: list[Wall],
    articulated: bool,
    options: GenerationConfig,
) -> float:
    """The matched yaw, refined by the cloud (A.7) or, if the object touches a wall, by the wall (A.3)."""
    if touched:
        return turned_to(yaw, wall_axes(touched[0].normal))
    if options.refinement == "off" or rectangularity(cloud, box.yaw) < options.rectangularity:
        return yaw
    limit = options.snap_articulated if articulated else options.snap_other
    return turned_to(yaw, box.yaw, None if limit is None else float(np.deg2rad(limit)))


def walls_reached(mounting: Mounting, touched: list[Wall], box: UprightBox, is_round: bool) -> list[Wall]:
    """The walls that an asset is extended to: not what stands on furniture, nor what is as deep as it is wide."""
    if mounting.type == 3 and (is_round or box.bottom > ON_FURNITURE):
        return []
    return touched


def sized(
    box: UprightBox,
    cloud: NDArray[np.floating],
    asset: Asset,
    mounting: Mounting,
    reached: list[Wall],
    camera: NDArray[np.float64],
    depth_error: DepthError,
    options: GenerationConfig,
) -> UprightBox:
    """The box with a believable depth, that of the asset if the cloud tells none.

    What was extended to a wall and is far too deep does not reach it: its front was seen, its rear was not.
    """
    if not reached:
        if top_seen(cloud, box, camera, depth_error):
            return box
        return believable_box(box, asset.size, camera - np.asarray(box.center), options.aspect_range)
    normal = np.asarray(reached[0].normal)
    unknown = only_noise(cloud, normal, camera, depth_error)
    at_wall = believable_box(box, asset.size, -normal, (1, 1) if unknown else options.aspect_range)
    if mounting.type == 3 and not unknown and volume(at_wall) < volume(box):
        return believable_box(box, asset.size, normal, options.aspect_range)
    return at_wall


def place(
    item: SceneObject,
    cousin: Cousin,
    asset: Asset,
    cloud: NDArray[np.floating],
    scene: Objects,
    options: GenerationConfig,
    beyond: float = 0.0,
    bearings: tuple[float, float] | None = None,
) -> Placed:
    """One asset with the object's yaw, extents and position, not yet on its support.

    Args:
        cloud: the object's points (N, 3), floor frame.
        scene: gives camera and walls.
        beyond: metres by which the asset's box reaches beyond its front.
        bearings: level directions between which the object is seen, radians, floor frame.
    """
    assert item.box is not None
    mounting = item.mounting or Mounting(type=2)
    touched = walls_of(mounting, scene.walls)
    camera = np.array(scene.floor_from_camera)[:3, 3]
    extracted = UprightBox(item.box.center, item.box.size, item.box.yaw)
    native = options.aspect_prior == "native"
    reached = walls_reached(mounting, touched, extracted, native and asset.symmetry == "full")
    is_round = native and asset.symmetry == "full" and not reached
    yaw = final_yaw(
        matched_yaw(cousin, extracted, camera, touched, options), item.box, cloud, touched, asset.articulated, options
    )
    at_least = options.min_extent
    if item.whole:
        changes: list[tuple[str, Change]] = [
            ("as the input tells it", lambda box: told_box(box, yaw, reached, at_least))
        ]
    else:
        axes = sight_yaw(extracted, camera) if is_round else yaw
        error = scene.depth_error if native else None

        def measured(box: UprightBox) -> UprightBox:
            return measured_box(cloud, box, axes, camera, options.trim, error, beyond, not is_round)

        def deep(box: UprightBox) -> UprightBox:
            if is_round:
                return round_box(box, options.aspect_range)._replace(yaw=yaw)
            return sized(box, cloud, asset, mounting, reached, camera, scene.depth_error, options)

        changes = [("measured along the model's axes", measured)]
        for wall in reached:
            changes.append((f"rear to {wall.id}", partial(against_wall, wall=wall, min_extent=at_least)))
        if is_round and bearings:
            changes.append(("as wide as its outline", partial(as_wide_as_seen, camera=camera, bearings=bearings)))
        if native:
            changes.append(("as deep as it can be", deep))
    if not reached:
        changes.append(("out of walls", partial(out_of_walls, walls=scene.walls)))
    changes.append(("least extent", lambda box: box._replace(size=np.maximum(box.size, at_least))))
    box, steps = changed(extracted, changes)
    return Placed(item.id, item.label, asset, box, mounting, cousin=cousin.rank, steps=steps)


def stacked(
    items: list[Placed],
    prisms: Mapping[str, list[Prism]],
    options: GenerationConfig,
    stated: Mapping[str, str] | None = None,
) -> list[Placed]:
    """Supports found and every item at its height (A.3), from low to high.

    Args:
        prisms: by id, in the asset frame.
        stated: by id, what carries it as a person says.
    """

    def beneath(item: Placed, lower: Placed) -> Surface:
        return surface_beneath(item, lower, placed_prisms(prisms[lower.id], lower))

    ordered = sorted_by_height(items)
    supports = support_tree(ordered, options.support_overlap, options.stack_tolerance, beneath)
    if stated:
        ordered, supports = carried(ordered, supports, stated)
    return told(
        "on what carries it", ordered, on_supports(ordered, supports, beneath, options.stack_tolerance is not None)
    )
