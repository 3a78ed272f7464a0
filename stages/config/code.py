"""A digest of the code behind a module, so that Snakemake re-runs what an edit touches and nothing else."""

import ast
import hashlib
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

PACKAGE = "stages"
ROOT = Path(__file__).resolve().parents[1]  # of the package
MODULE_NAME = re.compile(rf"{PACKAGE}(\.\w+)+")
DATA_SUFFIXES = {".jinja", ".html", ".css", ".js", ".csv", ".json"}  # shipped beside modules


@cache
def source(module: str) -> Path | None:
    """File of a module of this package, found without importing it; None if the name is no module."""
    head, *parts = module.split(".")
    if head != PACKAGE:
        return None
    path = ROOT.joinpath(*parts)
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return file
    return None


@cache
def _tree(module: str) -> ast.Module:
    path = source(module)
    return ast.parse(path.read_text(encoding="utf-8") if path else "")


def _origin(module: str, name: str) -> str:
    """The module that `from module import name` really needs (re-exports are followed)."""
    if source(f"{module}.{name}"):
        return f"{module}.{name}"
    for node in _tree(module).body:
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(PACKAGE):
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return _origin(node.module, alias.name)
    return module


@cache
def _needs(module: str) -> frozenset[str]:
    """Modules of this package that `module` imports, or names in a registry as text ("stages.x.y")."""
    found: set[str] = set()
    for node in ast.walk(_tree(module)):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(PACKAGE):
            found.update(_origin(node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and MODULE_NAME.fullmatch(node.value):
            found.add(node.value)
    return frozenset(name for name in found if source(name))


def closure(module: str) -> tuple[str, ...]:
    """`module` and every module of this package that it reaches, sorted."""
    seen: set[str] = set()
    queue = [module]
    while queue:
        name = queue.pop()
        if name not in seen:
            seen.add(name)
            queue.extend(_needs(name))
    return tuple(sorted(seen))


@cache
def code_digest(module: str) -> str:
    """Digest (12 hex digits) of `module`, of all it needs from this package, and of the data files beside them."""
    files = {path for name in closure(module) if (path := source(name))}
    for folder in {path.parent for path in files}:
        files.update(path for path in folder.iterdir() if path.suffix in DATA_SUFFIXES)
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]


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
            digest.update(f"{path.as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]
