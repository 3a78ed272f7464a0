"""Command `select`: which assets a policy experiment trains and tests on (paper B.4, Table 3)."""

import sys
from pathlib import Path

from roomkin.stages.contracts import Cousins, GeneratedScene, InputError, TaskAssets, read_json, write_json
from roomkin.stages.contracts.cousins import Distances, ObjectCousins
from roomkin.stages.contracts.library import Vector
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.scenes import find_true_model
from roomkin.stages.experiment.cousins import name_roles, usable_assets
from roomkin.stages.experiment.splits import with_lists
from roomkin.stages.plugins import load
from roomkin.stages.tasks.task import Task

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
        task=task,
        scene=matched.scene,
        object=object,
        encoder=matched.encoder,
        assets=[asset.model_copy(update={"role": role}) for role, asset in roles.items()],
        held_out=[number for number in held_out if number <= count],
    )
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
