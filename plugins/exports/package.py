"""What the core must know of this package."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from stages.config.code import source
from stages.config.packages import Package
from stages.contracts.training_run import TrainingRun
from stages.plugins import qualify_module

PACKAGE = Package(verbs={"scenes": None, "demonstrations": None, "policy": None})


def has_portable_form(run: TrainingRun) -> bool:
    """Whether `exports policy` can write policies of these options: they see clouds, and their kind has code for it."""
    return run.network.cloud and source(f"{qualify_module('policies', run.policy)}.portable") is not None


def with_portable_form(
    folders: Callable[[Any], list[str]], runs: Mapping[str, TrainingRun]
) -> Callable[[Any], list[str]]:
    """A function of a rule's inputs: of the policies' folders that `folders` gives, those that `policy` can write."""
    names = {name for name, run in runs.items() if has_portable_form(run)}
    return lambda wildcards: [folder for folder in folders(wildcards) if Path(folder).parent.name in names]
