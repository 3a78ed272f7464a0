"""Verb `choose`: which models to train on, what they cover, and what no set of that size can."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from plugins.studies.choice import Choice, ChosenModel
from plugins.studies.choice_report import report
from plugins.studies.coverage import CURVES, find_isolated, forecast_mean, measure_coverage, most_covered
from stages.contracts import InputError, read_json, write_json
from stages.contracts.cousins import Distances
from stages.contracts.errors import suggest_nearest
from stages.contracts.library import Vector
from stages.contracts.library_folder import AssetFolders
from stages.contracts.policies import TaskAsset
from stages.contracts.types import LARGEST
from stages.experiment.splits import by_chance, cover
from stages.experiment.usable import usable_assets
from stages.plugins import load
from stages.tasks.task import Task

Rule = Literal["chance", "cover", "nearest"]
BEST: Rule = "chance"  # by the studies so far: choice_report.WHY


def run(
    *,
    library: Path,
    task: str,
    count: int = 8,
    like: str | None = None,
    box: Vector | None = None,
    rule: Rule = BEST,
    distances: Path | None = None,
    snapshots: tuple[Path, ...] = (),
    seed: int = 0,
    out: Path | None = None,
) -> None:
    """Say which models of a library to train a policy on, by the rule that did best in our studies.

    They are of different families and open to one side. Printed are the models, what they cover in width of the front
    and height of the handle on it, the success that our studies let expect, and what no set of that size can cover.

    Args:
        library: library.json, its archives beside it.
        task: its name, e.g. door; one of a package of yours by its module.
        count: number of models.
        like: model of the object that the policy is for. All are loaded in its box and opened at the joint most like
            its own; of its family none is chosen. Without it they open to the side to which most do.
        box: extents (x, y, z) of the object in metres, instead of those of `--like`. Without either, own sizes.
        rule: chance; cover: by chance, spread over widths and heights; nearest: those that look most like `--like`, by
            `--distances`. The default has done best so far.
        distances: distances/<object>.json of matching, for the rule nearest.
        snapshots: shards (.h5), for pictures of the models in choice.png.
        seed: of the draw.
        out: folder to write choice.json and choice.png into.

    Raises:
        InputError: the library has fewer families than `count`, or not the model `like`; the box is none.
    """
    kind: Task = load("tasks", task)
    if box and not all(0 < side <= LARGEST for side in box):
        raise InputError("--box", f"{box} is no box.", "give x, y, z in metres", code="E-CHOOSE-BOX")
    pool = read_pool(kind, library, like, box, read_away(distances, like) if rule == "nearest" else None)
    families = len({asset.family for asset in pool})
    if not 0 < count <= families:
        what = f"has {families} families with a {kind.part_type} to open, {count} models are asked for."
        raise InputError(library, what, "set --count or make a larger library", code="E-CHOOSE-COUNT")
    chosen = by_rule(rule, pool, count, seed)
    choice = choice_of(pool, chosen, task=task, rule=rule, seed=seed, like=like, box=box)
    print("\n".join(report(choice, pool)))
    if out:
        from plugins.studies.choice_picture import write_picture  # slow to import

        write_json(out / "choice.json", choice)
        write_picture(out / "choice.png", choice, pool, snapshots)


def read_away(distances: Path | None, like: str | None) -> dict[str, float]:
    """How far all models look from `like`, of which the file must tell."""
    if distances is None or like is None:
        what, fix = "the nearest are those to --like by --distances.", "give both"
        raise InputError("--rule nearest", what, fix, code="E-CHOOSE-NEAREST")
    known = read_json(Distances, distances)
    if like not in known.distances:
        what, fix = f"has no distances from {like}.", suggest_nearest(like, known.distances)
        raise InputError(distances, what, fix, code="E-CHOOSE-NEAREST")
    return known.from_asset(like)


def read_pool(
    kind: Task, library: Path, like: str | None, box: Vector | None, away: dict[str, float] | None
) -> list[TaskAsset]:
    """The models among which is chosen, in order of id: all that the task can open at one side, as `run` says."""
    folders, front = AssetFolders(library), None
    if like is not None:
        if like not in folders:
            raise InputError(library, f"has no asset {like!r}.", suggest_nearest(like, folders), code="E-LIBRARY-ASSET")
        front, box = kind.target_joint(folders[like]), box or folders.asset(like).size
        if front is None:
            what = f"has {like!r}, which has no {kind.part_type} with a handle."
            raise InputError(library, what, "choose another asset", code="E-TASK-JOINT")
    models = usable_assets(kind, folders, front, away or dict.fromkeys(folders, 0.0), box)
    sides = Counter(model.hinge for model in models.values())
    side = front.hinge if front else next((hinge for hinge, _ in sides.most_common(1)), None)
    family = folders.asset(like).family if like is not None else None
    return [models[name] for name in sorted(models) if models[name].hinge == side and models[name].family != family]


def by_rule(rule: Rule, pool: Sequence[TaskAsset], count: int, seed: int) -> list[TaskAsset]:
    """So many models of the pool, each of another family."""
    rng, first = np.random.default_rng(seed), dict[str, TaskAsset]()
    if rule == "chance":
        return by_chance(pool, rng)[:count]
    if rule == "cover":
        return cover(pool, count, rng)
    for asset in sorted(pool, key=lambda asset: (asset.distance, asset.asset)):
        first.setdefault(asset.family, asset)
    return list(first.values())[:count]


def choice_of(
    pool: Sequence[TaskAsset], chosen: Sequence[TaskAsset], *, task: str, rule: Rule, seed: int, like: str | None,
    box: Vector | None,
) -> Choice:  # fmt: skip
    """What was chosen, and what it covers of the pool."""
    families = {asset.family for asset in chosen}
    unseen = [asset for asset in pool if asset.family not in families]
    most = most_covered(pool, len(chosen), 1)
    known = task in CURVES and unseen
    return Choice(
        task=task,
        rule=rule,
        seed=seed,
        like=like,
        box=box,
        usable=len(pool),
        families=len({asset.family for asset in pool}),
        models=[ChosenModel(**asset.model_dump(include=set(ChosenModel.model_fields))) for asset in chosen],
        within_1=round(measure_coverage(pool, chosen, 1), 4),
        within_2=round(measure_coverage(pool, chosen, 2), 4),
        greedy_within_1=round(most.greedy, 4),
        most_within_1=round(most.bound, 4),
        forecast=round(forecast_mean(task, unseen, chosen), 4) if known else None,
        alone=[asset.asset for asset in find_isolated(pool, 1)],
    )
