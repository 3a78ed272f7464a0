"""Packages beside the core, `plugins/<name>/`: each brings code, rules, tests and a part of the config (package.py)."""

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from pydantic import create_model

from roomkin.stages import plugins
from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.section import Section

C = TypeVar("C", bound=Section)
Objects = Callable[[], Mapping[str, Mapping[str, bool]]]


@dataclass(frozen=True)
class Package:
    """A package as the core knows it.

    Attributes:
        judges: whether judges of matching read its sections, each that of its name, so that variants may change them.
        draws: modules with which commands show more, by stage: matching: `InPlace` shows cousins in an object's place;
            demonstrations: `film_demonstrations` and evaluation: `RolloutFilms` film episodes; tables: `add_tables`
            adds to Table 3.
        section: of config.yaml that its commands read.
        shards: of the section `assets`, the shards of models that its rules add to the library, by name.
        commands: its commands that rules call, and what each reads of the config (None: nothing).
        rooms: of the whole config, scenes that it makes: by name, what gives their objects, each with whether it has a
            door, a drawer; empty: not known.
        sections: of config.yaml that belong to it, and further keys, by name, as pydantic fields.
        outside: of the whole config, files that its jobs read and that may lie outside the working directory.
        mistakes: of the whole config, `Mistake`s that the package finds in it.
        guard: module that runs a user's command, `python -m GUARD COMMAND ...`, so that it ends with the workflow.
        facts: module and command that write what the core knows of the package, `python -m FACTS`.
        keys: of the whole config, environment variables of keys that it sends to a server; None: it asks none.
    """

    section: str = ""
    guard: str = ""
    facts: str = ""
    judges: bool = False
    draws: Mapping[str, str] = field(default_factory=dict)
    rooms: Callable[[Any], Mapping[str, Objects]] = lambda config: {}
    shards: Callable[[Any], Mapping[str, Any]] = lambda assets: {}
    commands: Mapping[str, type[Section] | None] = field(default_factory=dict)
    sections: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)
    outside: Callable[[Any], list[str]] = lambda config: []
    keys: Callable[[Any], list[str] | None] = lambda config: None
    mistakes: Callable[[Any], Iterable[Any]] = lambda config: ()


@cache
def find_packages() -> dict[str, Package]:
    """The packages of this checkout by name; of one without package.py the core need know nothing."""
    found = {}
    for module in plugins.list_shipped():
        name = module.rpartition(".")[2]
        told = (plugins.PACKAGES / name / "package.py").is_file()
        found[name] = import_module(f"{module}.package").PACKAGE if told else Package()
    return found


def packages_on(on: Mapping[str, bool]) -> list[Package]:
    """The packages that are on."""
    return [package for name, package in find_packages().items() if on[name]]


def list_drawers(on: Mapping[str, bool], stage: str) -> list[str]:
    """Modules of packages that are on with which a command of a stage shows more."""
    return [package.draws[stage] for package in packages_on(on) if stage in package.draws]


def rule_files(on: Mapping[str, bool]) -> list[str]:
    """The rules.smk of packages that are on, below the workflow's folder."""
    names = [name for name in find_packages() if on[name] and (plugins.PACKAGES / name / "rules.smk").is_file()]
    return [f"plugins/{name}/rules.smk" for name in names]


def check_targets(asked: Collection[str], on: Mapping[str, bool], image: str = "") -> None:
    """Refuse targets of packages that are off, and the one of a picture without a picture.

    Raises:
        InputError: one is asked for; the message names its package, or how a picture is given.
    """
    if "photo" in asked and not image:
        mend = "snakemake --cores 2 photo --config image=kitchen.jpg"
        raise InputError("image", "there is no picture.", mend, code="E-CONFIG-FILE")
    for name in (name for name in find_packages() if not on[name]):
        rules = "".join(file.read_text(encoding="utf-8") for file in (plugins.PACKAGES / name).glob("*.smk"))
        for target in {*re.findall(r"^rule (\w+):", rules, re.MULTILINE)} & set(asked):
            what = f"is a target of the package {name}, which is off."
            raise InputError(target, what, f"packages: {{{name}: true}}", code="E-CONFIG-CLASH")


def check_rules(command: Sequence[str], snakefile: str) -> None:
    """Refuse targets that are no files and no rules of ours, unless another workflow has ours as a module.

    Args:
        command: a command line of Snakemake; of nothing else is anything asked.
        snakefile: that of the workflow.

    Raises:
        InputError: tells the nearest rule.
    """
    home = plugins.PACKAGES.parent
    ours = [file for file in (home / "Snakefile", home / "workflow/Snakefile") if file.is_file()]
    if Path(snakefile).resolve() not in ours or not command or Path(command[0]).name != "snakemake":
        return
    from snakemake.cli import get_argument_parser

    asked = get_argument_parser().parse_known_args(command[1:])[0].targets
    files = [*ours, *home.glob("rules/*.smk"), *plugins.PACKAGES.glob("*/*.smk")]
    texts = [file.read_text(encoding="utf-8") for file in files]
    rules = {name for text in texts for name in re.findall(r"^(?:rule|checkpoint) (\w+):", text, re.MULTILINE)}
    for name in asked:
        if name not in rules and not re.search(r"[./]", name):
            raise InputError(name, "is no target.", suggest_nearest(name, sorted(rules)), code="E-WORDS")


def with_sections(model: type[C], names: Iterable[str], judges: bool = False) -> type[C]:
    """A section with those of these packages; `judges`: with those alone that judges of theirs read."""
    extended: type[C] = _with_sections(model, tuple(names), judges)
    return extended


@cache
def _with_sections(model: Any, names: tuple[str, ...], judges: bool) -> Any:
    packages = find_packages()
    fields: dict[str, Any] = {}
    for name in names:
        fields |= packages[name].sections if packages[name].judges or not judges else {}
    return create_model(model.__name__, __base__=model, __doc__=model.__doc__, **fields) if fields else model


def shards_of(config: Any) -> dict[str, Any]:
    """The shards of models that packages which are on add to the library, by name."""
    on = packages_on(config.packages)
    return {name: shard for package in on for name, shard in package.shards(config.assets).items()}


def load_command(stage: str, name: str) -> Callable[..., None]:
    """A command of a stage or package as a function."""
    run: Callable[..., None] = import_module(f"{home_of(stage)}.{name}").run
    return run


def home_of(stage: str) -> str:
    """The Python package of a stage's commands: `stages.<stage>`, or that of a package beside the core."""
    package = f"roomkin.plugins.{stage}"
    return package if package in plugins.list_shipped() else f"roomkin.stages.{stage}"
