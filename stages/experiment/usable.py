"""The assets of the library that a task can open, with the size and place of their fronts and handles."""

from collections.abc import Mapping
from pathlib import Path

from roomkin.stages.articulated.affordance import Affordance
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.articulated.handle_extents import handle_extents
from roomkin.stages.contracts.library import Vector
from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.tasks.task import Task


def usable_assets(
    kind: Task,
    folders: Mapping[str, Path],
    like: Affordance | None,
    distances: Mapping[str, float],
    size: Vector | None,
) -> dict[str, TaskAsset]:
    """The assets with a joint for the task, by id, each at the joint most like the twin's; their roles are open.

    Args:
        kind: the task.
        folders: asset folders by id.
        like: the twin's joint.
        distances: embedding distance of every asset to the twin.
        size: the box (x, y, z) in which all are loaded, metres; None: each at its own size.
    """
    fronts = {asset: kind.target_joint(folders[asset], like) for asset in distances if asset in folders}
    return {
        asset: describe_asset(folders[asset], front, distances[asset], size) for asset, front in fronts.items() if front
    }


def describe_asset(folder: Path, front: Affordance, distance: float, size: Vector | None) -> TaskAsset:
    """One asset in the box `size`, opened at `front`."""
    asset = read_asset(folder)
    size = size or asset.size
    low, high = handle_extents(folder, asset, front.joint)
    _, wide, tall = ((high - low) / asset.size * size).tolist()
    middle = ((low + high)[2] / 2 - asset.box_min[2]) / asset.size[2]
    return TaskAsset(
        role="usable",
        asset=asset.id,
        category=asset.category,
        family=asset.family,
        digest=asset.checksum,
        joint=front.joint,
        size=size,
        distance=distance,
        handle=front.handle,
        hinge=front.hinge,
        panel_height=round(front.height * size[2], 4),
        panel_size=(round(front.width * size[1], 4), round(front.tall * size[2], 4)),
        handle_length=round(max(wide, tall), 4),
        handle_height=round(0.5 + (middle - front.height) / front.tall, 4),
    )
