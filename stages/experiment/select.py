"""Command `select`: which assets a policy experiment trains and tests on, cousins or not (paper B.4, Table 3)."""

import sys
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

from roomkin.stages.articulated.affordance import Affordance, handle_extents
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.contracts import Cousins, GeneratedScene, InputError, TaskAssets, read_json, write_json
from roomkin.stages.contracts.cousins import Distances, ObjectCousins
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.contracts.scenes import find_true_model
from roomkin.stages.contracts.types import Vector
from roomkin.stages.experiment.splits import with_lists
from roomkin.stages.plugins import load
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
    found = {asset: front for asset, front in fronts.items() if front}
    return {asset: describe_asset(folders[asset], front, distances[asset], size) for asset, front in found.items()}


def describe_asset(folder: Path, front: Affordance, distance: float, size: Vector | None) -> TaskAsset:
    """One asset in the box `size`, opened at `front`."""
    asset = read_asset(folder)
    size = size or asset.size
    low, high = handle_extents(folder, asset, front.joint)
    _, wide, tall = ((high - low) / asset.size * size).tolist()
    middle = ((low + high)[2] / 2 - asset.box_min[2]) / asset.size[2]
    return TaskAsset(
        role="usable", asset=asset.id, category=asset.category, family=asset.family, digest=asset.checksum,
        joint=front.joint, size=size, distance=distance, handle=front.handle, hinge=front.hinge,
        panel_height=round(front.height * size[2], 4),
        panel_size=(round(front.width * size[1], 4), round(front.tall * size[2], 4)),
        handle_length=round(max(wide, tall), 4), handle_height=round(0.5 + (middle - front.height) / front.tall, 4),
    )  # fmt: skip


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


ALL_CATEGORIES = 3  # nearest categories whose assets make up the training set `all` (paper, Figure 9)
STALE = "run `roomkin matching distances` again"


def run(
    *,
    cousins: Path,
    scene_file: Path,
    object: str,
    task: str,
    library: Path,
    distances: Path,
    out: Path,
    truth: Path | None = None,
    objects: Path | None = None,
    count: int = 10,
    held_out: tuple[int, ...] = (),
    test_assets: int = 40,
    draws: int = 1,
    seed: int = 0,
) -> None:
    """Write the TaskAssets of a named object: its roles, and the assets of training, validation and test.

    The twin is the object's true model where the truth is given, else its best cousin with a joint for the task. The
    cousins are the `count` nearest other such assets among the object's candidates, by embedding distance to the twin
    between representative snapshots, as in Table 3; if those are too few, also what `count_threshold` held back of
    their categories. Each is of another family than the twin and the other cousins, and opens to the twin's side at
    the joint most like the twin's. The dissimilar asset is the farthest one of the whole library whose kind of handle
    and hinge side some training asset shows: it differs in shape. The families that are left are split into training,
    validation and test. Every asset is loaded in the box of the object, as the official code does.

    Args:
        cousins: cousins.json of the scene that holds the object.
        scene_file: scene_1.json of generation; the object's size is read from it.
        object: id of the object, e.g. cabinet_1.
        task: its name, e.g. door; one of a package of yours by its module.
        library: library.json, its archives beside it.
        distances: distances/<object>.json of matching.
        out: file to write.
        truth: truth.json of the room, if there is one.
        objects: objects.json of extraction, which says which mask of the truth is which object.
        count: number of cousins.
        held_out: numbers of the cousins that no policy is trained on.
        test_assets: at most so many assets in the lists of validation and of test each.
        draws: how often assets are drawn for the training sets random_n and cover_n.
        seed: of the split and of the assets drawn by chance.
    """
    kind: Task = load("tasks", task)
    folders = AssetFolders(library)
    matched, scene = read_json(Cousins, cousins), read_json(GeneratedScene, scene_file)
    alike = read_distances(distances, matched, object)

    def can_open(asset: str) -> bool:
        return asset in folders and kind.target_joint(folders[asset]) is not None

    item = next((entry for entry in matched.objects if entry.id == object), None)
    size = next((placed.size for placed in scene.objects if placed.id == object and placed.status == "ok"), None)
    best = next((cousin.asset for cousin in item.cousins if can_open(cousin.asset)), None) if item else None
    true = find_true_model(truth, objects, object)
    twin = true or best
    if item is None or size is None or twin is None or not can_open(twin):
        would_do = [e.id for e in matched.objects if any(can_open(cousin.asset) for cousin in e.cousins[:1])]
        what = f"object '{object}' {_explain_refusal(item, kind.part_type, size, true)}."
        fix = f"objects that would do for a {kind.part_type}: {', '.join(would_do) or 'none'}"
        raise InputError(cousins, what, fix, code="E-EXPERIMENT-OBJECT")
    print(f"twin: {twin}, {f'the true model; matching chose {best}' if true else 'by matching'}", file=sys.stderr)
    if twin not in alike.distances:
        raise InputError(distances, f"has no distances from {twin}, the twin.", STALE, code="E-DISTANCES-STALE")
    usable = usable_assets(kind, folders, kind.target_joint(folders[twin]), alike.from_asset(twin), size)
    roles = name_roles(usable, twin, best, item, count, held_out)
    if f"cousin_{count}" not in roles:
        found = sum(role.startswith("cousin_") for role in roles)
        what = f"'{object}' has {found} cousins with a {kind.part_type} that has a handle, {count} are asked for."
        fix = "lower experiment.cousins, raise matching.k_cat, or make a larger library"
        raise InputError(library, what, fix, code="E-EXPERIMENT-COUSINS")
    plan = TaskAssets(
        task=task, scene=matched.scene, object=object, encoder=matched.encoder,
        assets=[asset.model_copy(update={"role": role}) for role, asset in roles.items()],
        held_out=[number for number in held_out if number <= count],
    )  # fmt: skip
    nearest = [category.category for category in item.categories[:ALL_CATEGORIES]]
    write_json(out, with_lists(plan, usable.values(), nearest, test_assets, seed, draws))


def read_distances(path: Path, matched: Cousins, object: str) -> Distances:
    """The distances, checked to be those of the object and of its cousins."""
    alike = read_json(Distances, path, STALE)
    if (alike.scene, alike.object, alike.encoder) != (matched.scene, object, matched.encoder):
        what = f"is of '{alike.object}' in {alike.scene} by {alike.encoder}, not of '{object}' in {matched.scene}."
        raise InputError(path, what, STALE, code="E-DISTANCES-STALE")
    return alike


def _explain_refusal(item: ObjectCousins | None, part: str, size: Vector | None, true: str | None) -> str:
    if item is None:
        return "is not in the scene"
    if item.status == "failed":
        return f"failed ({item.reason})"
    if size is None and (item.cousins or true):
        return "was not placed in the scene"
    return f"is truly {true}, which has no {part} to open" if true else f"has no cousin with a {part} to open"
