"""The provenance of a file: digests of inputs and of the code behind a module: an edit re-runs what it touches."""

import ast
import hashlib
import os
import re
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from zipfile import ZipFile, is_zipfile

from pydantic import BaseModel

from roomkin.stages import plugins
from roomkin.stages.contracts.doubt import Provenance

ROOTS = {"roomkin": plugins.PACKAGES.parent}  # whose code counts
MODULE_NAME = re.compile(r"""["'](\w+(?:\.\w+)+)(?::\w+)?["']""")  # as text: "stages.x.y" or "stages.x.y:Class"
EVERY = re.compile(r"""load_all\(["'](\w+)["']\)""")  # all implementations of a kind
# Import statements are cut out before they are parsed: whole modules take a second more at every start of the workflow.
IMPORT = re.compile(r"^[ \t]*((?:from\s+[\w.]+\s+)?import\b\s*(?:\([^)]*\)|(?:\\\n|[^\n(])*))", re.MULTILINE)
# Of files beside modules that a digest counts.
DATA_SUFFIXES = {*(".jinja", ".mplstyle", ".html", ".css", ".js"), *(".csv", ".json", ".txt", ".npz", ".safetensors")}


def cover(packages: Iterable[str]) -> None:
    """Let the code of the user's packages count as ours does."""
    forget()
    for package in packages:
        head = package.partition(".")[0]
        if head != "roomkin":
            ROOTS[head] = plugins.folder(head)


def path_of_jobs(packages: Iterable[str], here: Path) -> str:
    """PYTHONPATH for jobs, which run in `here`: they find the user's packages where the config found them.

    `python -m snakemake` looks where it was started, too, and PYTHONPATH may be relative to there.
    """
    places = [str(plugins.folder(package.partition(".")[0]).parent) for package in packages]
    places = [place for place in places if place != str(here) and not place.endswith("-packages")]
    before = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    return os.pathsep.join(dict.fromkeys([*before, *places]))


@cache
def source(module: str) -> Path | None:
    """File of a module of ours or of the user's, found without importing it; None if the name is no module."""
    head, *parts = module.split(".")
    if head not in ROOTS:
        return None
    path = ROOTS[head].joinpath(*parts)
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return file
    return None


@cache
def _text(module: str) -> str:
    path = source(module)
    return _read_bytes(path).decode() if path else ""


@cache
def _imports(module: str) -> tuple[ast.stmt, ...]:
    """The import statements of a module, wherever they stand."""
    statements: list[ast.stmt] = []
    for text in IMPORT.findall(_text(module)):
        with suppress(SyntaxError):  # a line of prose that begins like one
            statements += ast.parse(text).body
    return tuple(statements)


def _origin(module: str, name: str) -> str:
    """The module that `from module import name` really needs (re-exports are followed)."""
    if source(f"{module}.{name}"):
        return f"{module}.{name}"
    for node in _imports(module):
        if isinstance(node, ast.ImportFrom) and source(origin := _resolve_import(node, module)):
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return _origin(origin, alias.name)
    return module


def _resolve_import(node: ast.ImportFrom, module: str) -> str:
    """The module that `from ... import` in `module` names; a leading dot is relative to its package."""
    if not node.level:
        return node.module or ""
    path = source(module)
    parts = module.split(".")
    package = parts[: len(parts) - node.level + (path is not None and path.name == "__init__.py")]
    return ".".join([*package, node.module] if node.module else package)


@cache
def _list_needs(module: str) -> frozenset[str]:
    """Modules that `module` imports, loads all of, or names as text, as far as they count."""
    found: set[str] = set()
    for node in _imports(module):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = _resolve_import(node, module)  # a folder without `__init__.py` is no file, what lies in it is
            found.update(_origin(origin, alias.name) for alias in node.names)
    found.update(MODULE_NAME.findall(_text(module)))
    for kind in EVERY.findall(_text(module)):
        found.update(plugins.list_available(kind).values())
    if "iter_modules(__path__)" in _text(module) and (path := source(module)):  # a package that imports all it has
        found.update(f"{module}.{file.stem}" for file in path.parent.glob("[!_]*.py"))
    return frozenset(name for name in found if source(name))


def closure(*modules: str) -> tuple[str, ...]:
    """The modules and all that they reach, sorted."""
    seen: set[str] = set()
    queue = [*modules]
    while queue:
        name = queue.pop()
        if name not in seen:
            seen.add(name)
            queue.extend(_list_needs(name))
    return tuple(sorted(seen))


@cache
def code_digest(*modules: str) -> str:
    """Digest (12 hex digits) of the modules, of all that they need, and of the data files beside them."""
    files = {path for name in closure(*modules) if (path := source(name))}
    for folder in {path.parent for path in files}:
        files.update(_list_data(folder))
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.name.encode() + b"\0" + _read_bytes(path) + b"\0")
    return digest.hexdigest()[:12]


@cache
def _list_data(folder: Path) -> tuple[Path, ...]:
    return tuple(path for path in folder.iterdir() if path.suffix in DATA_SUFFIXES)


@cache
def _read_bytes(path: Path) -> bytes:
    return path.read_bytes()


def forget() -> None:
    """Read the code anew for the next digest."""
    for cached in (source, _text, _imports, _list_needs, _list_data, _read_bytes, code_digest):
        cached.cache_clear()


def files_digest(names: Iterable[str]) -> str:
    """Digest (12 hex digits) of files and of all files below folders, by name and content.

    Raises:
        FileNotFoundError: one of them does not exist.
    """
    digest = hashlib.sha256()
    for name in names:
        given = Path(name)
        inside = [path for path in sorted(given.rglob("*")) if path.is_file() and "__pycache__" not in path.parts]
        for path in inside if given.is_dir() else [given]:
            digest.update(f"{path.as_posix()}\0".encode())
            with path.open("rb") as file:
                while part := file.read(2**20):  # a model's file may be larger than the memory
                    digest.update(part)
            digest.update(b"\0")
    return digest.hexdigest()[:12]


def record_provenance(module: str, options: BaseModel, inputs: Iterable[Path], seed: int | None = None) -> Provenance:
    """Digests of a command's code, options and inputs.

    Args:
        module: the command's, with all that it imports.
        options: as the command takes them, defaults filled in.
        inputs: files that it reads, by content.
        seed: of the random numbers behind it, its own or its inputs'; None: none.
    """
    digest = hashlib.sha256()
    for path in inputs:
        digest.update(hashlib.sha256(content(path)).digest())
    own = hashlib.sha256(options.model_dump_json().encode()).hexdigest()
    return Provenance(seed=seed, options=own[:12], inputs=digest.hexdigest()[:12], code=code_digest(module))


def content(path: Path) -> bytes:
    """A file's bytes; of NumPy's archives those of the arrays, as their headers are of Python's own version."""
    if path.suffix != ".npz" or not is_zipfile(path):
        return path.read_bytes()
    with ZipFile(path) as archive:
        return b"".join(name.encode() + archive.read(name) for name in archive.namelist())
