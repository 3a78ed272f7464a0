"""Verb `select`: the assets of a policy experiment, by embedding distance to the twin (paper B.4, Table 3)."""

import sys
from pathlib import Path

from stages.articulated.affordance import Affordance
from stages.contracts import Cousins, GeneratedScene, InputError, Library, TaskAssets, read_json, write_json
from stages.contracts.cousins import ObjectCousins
from stages.contracts.distances import Distances
from stages.contracts.library import LibraryEntry, Vector
from stages.contracts.policies import TaskAsset
from stages.plugins import load
from stages.tasks.task import Task

ALL_CATEGORIES = 3  # nearest categories whose assets make up the training set `all` (paper, Figure 9)
TAUGHT = 4  # training cousins that show the kinds of handle which held-out ones may have
STALE = "run `python -m stages.matching distances` again"


def run(
    *,
    cousins: Path,
    scene_file: Path,
    object: str,
    task: str,
    library: Path,
    distances: Path,
    out: Path,
    count: int = 10,
    held_out: tuple[int, ...] = (),
) -> None:
    """Write the TaskAssets of a named object: twin, cousins, and one dissimilar asset.

    The twin is the object's best cousin with a joint for the task. The cousins are `count` other such
    assets from the object's candidates, ordered by their embedding distance to the twin between
    representative snapshots, as in Table 3. If the candidates are too few, what `count_threshold` held
    back of their categories is used as well. All open to the twin's side, each at the joint most like
    the twin's, and what is held out has a kind of handle that training shows. The dissimilar asset is
    the farthest one of the whole library whose kind of handle and hinge side some training asset
    shows: it differs in shape. Every asset is loaded in the box of the object, as the official code does.

    Args:
        cousins: cousins.json of the scene that holds the object.
        scene_file: scene_1.json of generation; the object's size is read from it.
        object: id of the object, e.g. cabinet_1.
        task: its name, e.g. door; one of a package of yours by its module.
        library: library.json, with the asset folders it names.
        distances: distances/<object>.json of matching.
        out: file to write.
        count: number of cousins.
        held_out: numbers of the cousins that no policy is trained on.
    """
    kind: Task = load("tasks", task)
    entries = {entry.id: entry for entry in read_json(Library, library).assets}
    matched, scene = read_json(Cousins, cousins), read_json(GeneratedScene, scene_file)
    alike = read_distances(distances, matched, object)
    folders = {id: library.parent / entry.folder for id, entry in entries.items()}

    def usable(asset: str, like: Affordance | None = None) -> Affordance | None:
        entry = entries.get(asset)
        return kind.target_joint(folders[asset], like) if entry and entry.doors + entry.drawers else None

    item = next((entry for entry in matched.objects if entry.id == object), None)
    twin = next((cousin for cousin in item.cousins if usable(cousin.asset)), None) if item else None
    size = next((placed.size for placed in scene.objects if placed.id == object and placed.status == "ok"), None)
    if item is None or twin is None or size is None:
        would_do = [e.id for e in matched.objects if any(usable(cousin.asset) for cousin in e.cousins[:1])]
        what = f"object '{object}' {_why_not(item, kind.role, size)}."
        raise InputError(cousins, what, f"objects that would do for a {kind.role}: {', '.join(would_do) or 'none'}")
    if twin.rank > 1:
        print(f"twin: cousin {twin.rank} of {object}; those before have no {kind.role} with a handle", file=sys.stderr)

    like = kind.target_joint(folders[twin.asset])
    fronts = {asset: front for asset in alike.assets if (front := usable(asset, like))}
    if twin.asset not in alike.distances:
        raise InputError(distances, f"has no distances from {twin.asset}, the twin.", STALE)
    far = {asset: distance for asset, distance in alike.from_asset(twin.asset).items() if asset in fronts}
    chosen = choose_cousins(item, twin.asset, far, entries, fronts, count, held_out)
    if len(chosen) < count:
        what = f"'{object}' has {len(chosen)} cousins with a {kind.role} that has a handle, {count} are asked for."
        raise InputError(library, what, "lower experiment.cousins, raise matching.k_cat, or make a larger library")
    roles = {"twin": twin.asset} | {f"cousin_{number}": asset for number, asset in enumerate(chosen, 1)}
    hidden = {asset for number, asset in enumerate(chosen, 1) if number in held_out}
    others = [asset for asset in far if asset not in roles.values()]
    if others:
        known = [fronts[asset] for asset in roles.values() if asset not in hidden]
        roles["dissimilar"] = choose_dissimilar(others, far, fronts, known)
    nearest = [category.category for category in item.categories[:ALL_CATEGORIES]]
    all_assets = sorted(
        (a for a in far if entries[a].category in nearest and a not in {*hidden, roles.get("dissimilar")}),
        key=lambda asset: (far[asset], asset),
    )

    def described(role: str, asset: str) -> TaskAsset:
        front = fronts[asset]
        return TaskAsset(
            role=role,
            asset=asset,
            category=entries[asset].category,
            joint=front.joint,
            size=size,
            distance=far[asset],
            handle=front.handle,
            hinge=front.hinge,
            panel_height=round(front.height * size[2], 4),
            panel_size=(round(front.width * size[1], 4), round(front.tall * size[2], 4)),
        )

    plan = TaskAssets(
        task=task,
        scene=matched.scene,
        object=object,
        encoder=matched.encoder,
        assets=[described(role, asset) for role, asset in roles.items()],
        all_assets=[described("all", asset) for asset in all_assets],
    )
    write_json(out, plan)


def choose_dissimilar(
    others: list[str], far: dict[str, float], fronts: dict[str, Affordance], known: list[Affordance]
) -> str:
    """The farthest asset whose kind of handle and hinge side occur in training; failing that, whose hinge side does."""
    ways = {(front.handle, front.hinge) for front in known}
    sides = {front.hinge for front in known}

    def order(asset: str) -> tuple[bool, bool, float, str]:
        front = fronts[asset]
        return (front.handle, front.hinge) in ways, front.hinge in sides, far[asset], asset

    return max(others, key=order)


def read_distances(path: Path, matched: Cousins, object: str) -> Distances:
    """The distances, checked to be those of the object and of its cousins."""
    alike = read_json(Distances, path, STALE)
    if (alike.scene, alike.object, alike.encoder) != (matched.scene, object, matched.encoder):
        what = f"is of '{alike.object}' in {alike.scene} by {alike.encoder}, not of '{object}' in {matched.scene}."
        raise InputError(path, what, STALE)
    return alike


def choose_cousins(
    item: ObjectCousins,
    twin: str,
    distances: dict[str, float],
    entries: dict[str, LibraryEntry],
    fronts: dict[str, Affordance],
    count: int,
    held_out: tuple[int, ...] = (),
) -> list[str]:
    """The `count` cousins, nearest to the twin first: from the object's candidates, then from their categories.

    They open to the twin's side. A held-out one whose kind of handle none of the nearest cousins in training has is
    left out and the others move up, as long as there are enough: its failures would say nothing of generalisation.
    """
    candidates = {candidate.asset for candidate in item.by_distance}
    categories = {category.category for category in item.categories}
    pool = [
        asset
        for asset in distances
        if asset != twin and entries[asset].category in categories and fronts[asset].hinge == fronts[twin].hinge
    ]
    pool.sort(key=lambda asset: (asset not in candidates, distances[asset], asset))
    while True:
        nearest = sorted(pool[:count], key=lambda asset: (distances[asset], asset))
        shown = [asset for number, asset in enumerate(nearest, 1) if number not in held_out][:TAUGHT]
        kinds = {fronts[asset].handle for asset in shown}
        hidden = (asset for number, asset in enumerate(nearest, 1) if number in held_out)
        strange = next((asset for asset in hidden if fronts[asset].handle not in kinds), None)
        if strange is None or len(pool) <= count:
            return nearest
        pool.remove(strange)


def _why_not(item: ObjectCousins | None, role: str, size: Vector | None) -> str:
    if item is None:
        return "is not in the scene"
    if item.status == "failed":
        return f"failed ({item.reason})"
    return "was not placed in the scene" if size is None and item.cousins else f"has no cousin with a {role} to open"
