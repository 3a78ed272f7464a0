"""The package as the core knows it."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from roomkin.stages.config.code import source
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.packages import Package
from roomkin.stages.contracts.policy_config import PolicyConfig, has_eyes
from roomkin.stages.plugins import qualify_module


def find_mistakes(config: Any) -> Iterator[Mistake]:
    """Scenes are exported with the light and colors that the package `pictures` draws them in."""
    if not config.packages.get("pictures"):
        what = "is off or not here, and exports of scenes have the light and colors of its pictures"
        yield Mistake("packages.pictures", what, "packages: {pictures: true}, or {exports: false}, too")


PACKAGE = Package(commands={"scenes": None, "demonstrations": None, "policy": None}, mistakes=find_mistakes)


def has_portable_form(run: PolicyConfig) -> bool:
    """Whether `exports policy` can write policies of these options: they see clouds, and their kind has code for it."""
    return has_eyes(run) and find_portable_form(run.policy) is not None


def find_portable_form(policy: str) -> str | None:
    """Module of the portable form of a kind of policy: of this package, or beside the policy; None: there is none."""
    module = qualify_module("policies", policy)
    forms = (f"roomkin.plugins.exports.{policy}.portable", f"{module}.portable")
    return next((form for form in forms if source(form)), None)


def with_portable_form(
    folders: Callable[[Any], list[str]], runs: Mapping[str, PolicyConfig]
) -> Callable[[Any], list[str]]:
    """A function of a rule's inputs: of the policies' folders that `folders` gives, those that `policy` can write."""
    names = {name for name, run in runs.items() if has_portable_form(run)}
    return lambda wildcards: [folder for folder in folders(wildcards) if Path(folder).parent.name in names]
