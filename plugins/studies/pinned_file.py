"""Committed files of a target's assets (a row per asset, or a run's `assets.json`): there, and about that target."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, ValidationError

from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, read_rows, refusal, write_text
from roomkin.stages.contracts.policies import TaskAsset, TaskAssets
from roomkin.stages.contracts.policy_config import DRAWN, read_set
from roomkin.stages.contracts.types import Extent, Id, Rank, SceneName, Size, Text

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


LISTS = ("all", "random", "cover", "validation", "test")  # roles whose assets stand in a list of that name
HEAD = ("task", "scene", "object", "encoder", "held_out", "draws")  # the same in all rows
Numbers = BeforeValidator(str.split)  # a cell of several, with blanks between


class PinnedAsset(TaskAsset):
    """A row: an asset, and the experiment that it is of."""

    size: Annotated[Size, Numbers]
    panel_size: Annotated[tuple[Extent, Extent], Numbers]
    task: Id
    scene: SceneName
    object: Id
    encoder: Text
    held_out: Annotated[list[Rank], Numbers]
    draws: Rank


def read_pinned(path: Path) -> TaskAssets:
    """The assets of a committed file, by its suffix a table (.csv) or JSON.

    Raises:
        InputError: it is missing, or breaks the contract (file, line and field named).
    """
    if path.suffix != ".csv":
        return read_json(TaskAssets, path)
    plan: dict[str, Any] = {}
    for number, row in enumerate(read_rows(PinnedAsset, path), 2):
        values = row.model_dump()
        head = {name: values.pop(name) for name in HEAD}
        if head != {name: plan.setdefault(name, head[name]) for name in HEAD}:
            what = f"is about another experiment than line 2 ({', '.join(HEAD)})."
            raise InputError(f"{path}:{number}", what, "keep each in a file of its own", code="E-CONTRACT-BROKEN")
        plan.setdefault(_list_of(row.role), []).append(values)
    try:
        return TaskAssets.model_validate(plan)
    except ValidationError as error:
        raise InputError(path, refusal(TaskAssets, error), code="E-CONTRACT-BROKEN") from None


def write_pinned(path: Path, plan: TaskAssets) -> None:
    """Write the assets as a table, in the order of the lists of `TaskAssets`."""
    head = {name: _cell(getattr(plan, name)) for name in HEAD}
    lists = ("assets", *(f"{name}_assets" for name in LISTS))
    rows = [asset for name in lists for asset in getattr(plan, name)]
    text = io.StringIO(newline="")
    table = csv.DictWriter(text, [*TaskAsset.model_fields, *HEAD], lineterminator="\n")
    table.writeheader()
    table.writerows({name: _cell(value) for name, value in asset.model_dump().items()} | head for asset in rows)
    write_text(path, text.getvalue())


def _list_of(role: str) -> str:
    return f"{role}_assets" if role in LISTS else "assets"


def _cell(value: Any) -> Any:
    return " ".join(map(str, value)) if isinstance(value, (list, tuple)) else value


def pinned_assets(config: "Config") -> Iterator[Mistake]:
    """Mistakes in `experiment.targets.<name>.assets`."""
    experiment = config.experiment
    for name, target in experiment.targets.items():
        key, file = f"experiment.targets.{name}", target.assets
        if file is None:
            continue
        if not Path(file).is_file():
            yield Mistake(f"{key}.assets", f"no file {file}", "correct the path, or null: chosen anew", "E-CONFIG-FILE")
            continue
        try:
            plan = read_pinned(Path(file))
        except InputError as error:
            mend = "choose the assets anew: docs/reproduce.md"
            yield Mistake(f"{key}.assets", str(error).rstrip("."), mend, error.code)
            continue
        if (plan.scene, plan.object) != (target.room, target.object):
            what = f"{target.object} of {target.room}, but {file} is about {plan.object} of {plan.scene}"
            yield Mistake(f"{key}.object", what, "name that object, or another file")
        cousins = sum(asset.role.startswith("cousin_") for asset in plan.assets)
        if cousins < experiment.cousins:
            what = f"{experiment.cousins}, but {file} has {cousins}"
            yield Mistake("experiment.cousins", what, "lower it, or choose the assets anew")
        if sorted(plan.held_out) != sorted(experiment.held_out):
            what = f"{experiment.held_out}, but {file} holds out {plan.held_out}"
            yield Mistake("experiment.held_out", what, "set it so, or choose the assets anew")
        drawn = [name for name in experiment.sets_of(name) if read_set(name).rule in DRAWN]
        if drawn and plan.draws < experiment.draws:
            what = f"{experiment.draws}, but {file} has {plan.draws} for {', '.join(drawn)}"
            yield Mistake("experiment.draws", what, "lower it, or choose the assets anew")
        for training_set in drawn:
            rule, count, _ = read_set(training_set)
            if count > plan.length(rule):
                what = f"{training_set} needs {count} assets, {file} has {plan.length(rule)} in a draw"
                yield Mistake("experiment.training_sets", what, "leave it out, or choose the assets anew")
