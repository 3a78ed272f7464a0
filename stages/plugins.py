"""Implementations by name, ours and the user's: an encoder, a task, a room ... (docs/extending.md).

An implementation is a module or a folder in the home package of its kind, and defines the kind's symbol. A user's
package has a sub-package per kind: `my_package/encoders/mine.py`. Nothing is imported to find one, only to use it.
"""

import importlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from roomkin.stages.contracts.errors import InputError, first_error, suggest_nearest
from roomkin.stages.contracts.section import Section

S = TypeVar("S", bound=Section)


@dataclass(frozen=True)
class PluginKind:
    """Where our implementations are, and the name that every implementation defines (or the suffix of its file)."""

    place: str  # no whole module name: as text that would count as needed by all who look for a name (config/code.py)
    symbol: str

    @property
    def home(self) -> str:
        """The package of our implementations."""
        return f"roomkin.stages.{self.place}"


KINDS = {
    "encoders": PluginKind("matching.encoders", "Encoder"),
    "text_encoders": PluginKind("matching.text_encoders", "TextEncoder"),
    "searches": PluginKind("matching.searches", "search"),
    "judges": PluginKind("matching.judges", "Judge"),
    "sources": PluginKind("extraction.sources", "observe"),
    "proposers": PluginKind("perception.segmentation", "propose"),
    "depth_sources": PluginKind("perception.depth_sources", "measure_depth"),
    "captioners": PluginKind("perception.captioners", "Captioner"),
    "rooms": PluginKind("scenes.rooms", ".yaml"),
    "tasks": PluginKind("tasks", "TASK"),
    "policies": PluginKind("policies", "Policy"),
    "makers": PluginKind("articulated.makers", "Maker"),
    "mesh_files": PluginKind("articulated.mesh_files", "READER"),
    "importers": PluginKind("assets.importers", "IMPORTER"),
    "skills": PluginKind("skills", "Skill"),
    "simulators": PluginKind("evaluation.simulators", "Environment"),
}


PACKAGES = Path(__file__).resolve().parents[1] / "plugins"  # those beside the core that ship with it


@cache
def list_shipped() -> tuple[str, ...]:
    """The packages beside the core that are in this checkout, as modules."""
    return tuple(f"roomkin.plugins.{file.parent.name}" for file in sorted(PACKAGES.glob("*/__init__.py")))


def folder(package: str) -> Path:
    """Folder of a package; only its first part is looked up, nothing is imported."""
    head, *parts = package.split(".")
    spec = find_spec(head)
    if spec is None or not spec.submodule_search_locations:
        fix = "put it into this folder, install it, or set PYTHONPATH"
        raise InputError("plugins", f"there is no package '{head}'.", fix, code="E-PLUGIN-PACKAGE")
    return Path(spec.submodule_search_locations[0]).joinpath(*parts)


def list_available(kind: str, packages: Sequence[str] | None = None) -> dict[str, str]:
    """Qualified module name of every implementation by its name: the core's and those of `packages` (None: all here).

    Raises:
        InputError: a package is not there, or a name is taken twice.
    """
    found: dict[str, str] = {}
    packages = list_shipped() if packages is None else packages
    for home in [KINDS[kind].home, *(f"{package}.{kind}" for package in packages)]:
        for file in sorted(folder(home).glob("*")):
            name = file.stem
            if name.startswith("_") or not _is_one(file, KINDS[kind].symbol):
                continue
            if name in found:
                what = f"{kind} '{name}' is in {found[name]} and in {home}."
                raise InputError("plugins", what, "rename yours", code="E-PLUGIN-TWICE")
            found[name] = f"{home}.{name}"
    return found


def find(kind: str, name: str, packages: Sequence[str] | None = None, key: str = "") -> str:
    """The name to load an implementation by: as it is for ours, qualified for a user's.

    Raises:
        InputError: there is none of that name; the message has the `key` of the config and what to do instead: turn
            its package on, or take the nearest name.
    """
    known = list_available(kind, packages)
    if name in known.values():
        return name
    if name not in known:
        package = "".join(_list_ours(kind).get(name, "").split(".")[2:3])
        off = f"packages: {{{package}: true}}, or one of {', '.join(known)}"
        mend = off if package else suggest_nearest(name, known)
        raise InputError(key or kind, f"there is no '{name}'.", mend, code="E-PLUGIN-UNKNOWN")
    return name if known[name] == _list_ours(kind).get(name) else known[name]


@cache
def _list_ours(kind: str) -> dict[str, str]:
    """Modules of the implementations of the core and of the packages in this checkout, by name."""
    return list_available(kind)


def qualify_module(kind: str, name: str) -> str:
    """Module of an implementation."""
    return name if "." in name else _list_ours(kind).get(name, f"{KINDS[kind].home}.{name}")


def shorten_name(name: str) -> str:
    """The name without its package, for files and tables."""
    return name.rpartition(".")[2]


def load(kind: str, name: str) -> Any:
    """Import what `find` found: the class, function or value that the module defines.

    Raises:
        InputError: there is no such module, or it defines no such thing.
    """
    module, symbol = qualify_module(kind, name if "." in name else find(kind, name)), KINDS[kind].symbol
    try:
        implementation = getattr(importlib.import_module(module), symbol, None)
    except ModuleNotFoundError as error:
        if not f"{module}.".startswith(f"{error.name}."):
            raise  # it is there, and misses something itself
        what, fix = f"there is no module {module}.", "put its package on PYTHONPATH"
        raise InputError(kind, what, fix, code="E-PLUGIN-PACKAGE") from None
    if implementation is None:
        raise InputError(kind, f"{module} defines no {symbol}.", "see docs/extending.md", code="E-PLUGIN-SYMBOL")
    return implementation


def find_options(kind: str, name: str) -> type[Section]:
    """The class `Options` of an implementation: in `<its module>_options`, or in its module, which is then imported.

    The first is for modules whose import takes long: the config is checked by it. `Section`, without keys: it has none.
    """
    module = qualify_module(kind, name)
    home, _, stem = module.rpartition(".")
    for place in (f"{stem}_options", stem):
        file = folder(home) / place
        if _is_one(file if file.is_dir() else file.with_suffix(".py"), "Options"):
            options: type[Section] = importlib.import_module(f"{home}.{place}").Options
            return options
    return Section


def parse_kwargs(options: type[S], kwargs: Mapping[str, Any], key: str = "kwargs") -> S:
    """The options of an implementation from those that are given.

    Raises:
        InputError: one is not known, or has no such value.
    """
    try:
        return options.model_validate(kwargs)
    except ValidationError as error:
        strange = [str(detail["loc"][0]) for detail in error.errors() if detail["type"] == "extra_forbidden"]
        mend = suggest_nearest(strange[0], options.model_fields) if strange else ""
        raise InputError(key, f"{first_error(error)}.", mend, code="E-PLUGIN-OPTION") from None


def load_all(kind: str) -> list[Any]:
    """Every implementation in the packages of this checkout; whoever asks needs the code of all (config/code.py)."""
    return [load(kind, module) for module in list_available(kind).values()]


def data_file(kind: str, name: str) -> Path:
    """File of an implementation that is data."""
    home, _, stem = qualify_module(kind, name).rpartition(".")
    return folder(home) / f"{stem}{KINDS[kind].symbol}"


def _is_one(file: Path, symbol: str) -> bool:
    """Whether a file has the suffix, or a module or folder defines or imports the name at its top level."""
    if symbol.startswith("."):
        return file.suffix == symbol
    module = file / "__init__.py" if file.is_dir() else file
    text = module.read_text(encoding="utf-8") if module.suffix == ".py" and module.is_file() else ""
    return re.search(rf"^(class |def |from .* import .*\b)?{symbol}\b", text, re.MULTILINE) is not None
