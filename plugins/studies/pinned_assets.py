"""Committed files of assets that targets name: they are there, and are about the target."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from roomkin.plugins.studies.pinned_file import read_pinned
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import DRAWN, read_set

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


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
