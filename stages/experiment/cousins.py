"""Assets that a task can open, by their fronts: which are cousins of the twin, which is dissimilar (paper B.4)."""

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

from roomkin.stages.articulated.affordance import Affordance, handle_extents
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.contracts.cousins import ObjectCousins
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


TAUGHT = 4  # training cousins that show the kinds of handle which held-out ones may have


def name_roles(
    usable: Mapping[str, TaskAsset],
    twin: str,
    matched: str | None,
    item: ObjectCousins,
    count: int,
    held_out: Collection[int],
) -> dict[str, TaskAsset]:
    """Twin, what matching chose where that is another asset, cousins (perhaps fewer than `count`), dissimilar asset.

    Args:
        usable: the assets that the task can open, by id.
        twin: id of the twin.
        matched: id of what matching chose.
        item: what matching found for the object: cousins are taken from its candidates, then from its categories.
        count: how many cousins are asked for.
        held_out: numbers of the cousins that no policy is trained on.
    """
    roles = {"twin": usable[twin]}
    if matched and matched != twin:
        roles["matched"] = usable[matched]
    candidates = {candidate.asset for candidate in item.by_distance}
    categories = {category.category for category in item.categories}
    wider = [a for a in usable.values() if a.category in categories and a.hinge == usable[twin].hinge]
    pools = [[asset for asset in wider if asset.asset in candidates], wider]
    cousins = choose_cousins(pools, {asset.family for asset in roles.values()}, count, held_out)
    roles |= {f"cousin_{number}": asset for number, asset in enumerate(cousins, 1)}
    taken = {asset.family for asset in roles.values()}
    hidden = {"matched", *(f"cousin_{number}" for number in held_out)}
    shown = [asset for role, asset in roles.items() if role not in hidden]
    dissimilar = choose_dissimilar((asset for asset in usable.values() if asset.family not in taken), shown)
    return roles | ({"dissimilar": dissimilar} if dissimilar else {})


def choose_cousins(
    pools: Iterable[list[TaskAsset]], taken: Collection[str], count: int, held_out: Collection[int]
) -> list[TaskAsset]:
    """The `count` cousins, nearest to the twin first, from the first of the pools that has enough; else all it has.

    Every cousin is of a family of its own. If no pool has families enough, those of the last pool that are trained on
    may be relatives of one another; a held-out one has none among them.

    Args:
        pools: assets that open to the twin's side, each pool larger than the one before.
        taken: families that no cousin may be of, such as the twin's.
        count: how many cousins are asked for.
        held_out: numbers of the cousins that no policy is trained on.
    """
    pool: list[TaskAsset] = []
    for assets in pools:
        pool = sorted((asset for asset in assets if asset.family not in taken), key=lambda a: (a.distance, a.asset))
        chosen = _of_known_handles(pool, count, held_out)
        if len(chosen) == count:
            return chosen
    return _in_order(pool, count, held_out, relatives=True)


def _of_known_handles(pool: list[TaskAsset], count: int, held_out: Collection[int]) -> list[TaskAsset]:
    """Cousins without relatives among them. A held-out one with a kind of handle that none of the nearest in training
    has is left out, as long as there are enough: its failures would say nothing of generalisation."""
    first = chosen = _in_order(pool, count, held_out)
    while len(chosen) == count:
        shown = [asset.handle for number, asset in enumerate(chosen, 1) if number not in held_out][:TAUGHT]
        hidden = [asset for number, asset in enumerate(chosen, 1) if number in held_out]
        strange = next((asset for asset in hidden if asset.handle not in shown), None)
        if strange is None:
            return chosen
        pool = [asset for asset in pool if asset is not strange]
        chosen = _in_order(pool, count, held_out)
    return first


def _in_order(pool: list[TaskAsset], count: int, held_out: Collection[int], relatives: bool = False) -> list[TaskAsset]:
    """The first assets of the pool whose family is not chosen yet; with `relatives`, not on the other side."""
    chosen: list[TaskAsset] = []
    trained: set[str] = set()
    hidden: set[str] = set()
    for asset in pool:
        hide = len(chosen) + 1 in held_out
        closed = hidden if relatives and not hide else hidden | trained
        if asset.family not in closed and len(chosen) < count:
            chosen.append(asset)
            (hidden if hide else trained).add(asset.family)
    return chosen


def choose_dissimilar(others: Iterable[TaskAsset], known: Iterable[TaskAsset]) -> TaskAsset | None:
    """The farthest asset whose kind of handle and hinge side occur in training; failing that, whose hinge side does."""
    ways = {(asset.handle, asset.hinge) for asset in known}
    sides = {hinge for _, hinge in ways}

    def order(asset: TaskAsset) -> tuple[bool, bool, float, str]:
        return (asset.handle, asset.hinge) in ways, asset.hinge in sides, asset.distance, asset.asset

    return max(others, key=order, default=None)
