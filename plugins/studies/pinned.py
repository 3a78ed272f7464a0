"""`pinned`: the assets of a policy experiment from a committed file, if the library has the very same models."""

from pathlib import Path

from roomkin.plugins.studies.pinned_file import read_pinned, write_pinned
from roomkin.stages.contracts import Asset, InputError, write_json
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.plugins import load
from roomkin.stages.tasks.task import Task

MEND = "set seed and section assets as when the file was written, or choose anew: experiment.tasks.<task>.assets: null"


def run(*, assets: Path, task: str, library: Path, out: Path) -> None:
    """Check that the library has every asset of the file as it was, and write the file for the task.

    A file serves all tasks that open the same joints: those of `drawer` also `put_away_bowl`.

    Args:
        assets: committed file (.csv or .json), or assets.json as `experiment select` wrote it.
        task: name of the task, e.g. door; one of a package of yours by its module.
        library: library.json, its archives beside it.
        out: file to write, JSON; .csv: a table to commit.

    Raises:
        InputError: the library lacks a model, has another of that name, or the task does not open its joint.
    """
    kind: Task = load("tasks", task)
    plan = read_pinned(assets)
    models = AssetFolders(library)
    lists = (plan.all_assets, plan.random_assets, plan.cover_assets, plan.validation_assets, plan.test_assets)
    for item in {item.asset: item for each in (plan.assets, *lists) for item in each}.values():
        if what := difference(item, models.asset(item.asset) if item.asset in models else None, kind):
            raise InputError(library, f"{what} in {assets}.", MEND, code="E-ASSETS-CHANGED")
    write = write_pinned if out.suffix == ".csv" else write_json
    write(out, plan.model_copy(update={"task": task}))
    print(out)


def difference(item: TaskAsset, asset: Asset | None, kind: Task) -> str:
    """How the library's model differs from the one that was chosen; empty: not at all."""
    if asset is None:
        return f"lacks {item.asset}, which is"
    if asset.checksum != item.digest:
        return f"has another {item.asset} (digest {asset.checksum[:12]}) than the one (digest {item.digest[:12]})"
    joint = next((joint for joint in asset.joints if joint.name == item.joint), None)
    if joint is None or joint.part_type != kind.part_type:
        return f"has {item.asset}, but its joint '{item.joint}' is no {kind.part_type} for the task, as"
    return ""
