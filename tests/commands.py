"""The commands of stages and packages, and the flags that rules pass them, read from the code without importing it."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from roomkin.stages.cli import find_module

ROOT = Path(__file__).resolve().parents[1]


def list_commands() -> Iterator[tuple[str, str]]:
    """Folder of every stage or package, below the root, and a command of it."""
    for path in [file for home in ("stages", "plugins") for file in sorted((ROOT / home).glob("*/__main__.py"))]:
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and len(call.args) == 2 and isinstance(call.args[1], ast.Dict):
                for name in ast.literal_eval(call.args[1]):  # main("matching", {"match": ...})
                    yield path.parent.relative_to(ROOT).as_posix(), name


def read_flags(folder: Path, command: str) -> tuple[set[str], set[str]]:
    """All flags of a command, and those without a default."""
    tree = ast.parse((folder / f"{find_module(command)}.py").read_text(encoding="utf-8"))
    run = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "run").args
    names = ["--" + argument.arg.replace("_", "-") for argument in run.kwonlyargs]
    return set(names), {name for name, default in zip(names, run.kw_defaults, strict=True) if default is None}


def list_rule_files() -> list[Path]:
    """The files of rules, of the core and of the packages; `make paper` is a workflow of its own."""
    files = [*sorted((ROOT / "rules").glob("*.smk")), *sorted((ROOT / "plugins").glob("*/*.smk"))]
    return [path for path in files if path.name != "paper.smk"]


def list_passed_flags() -> dict[tuple[str, str], set[str]]:
    """The flags that the rules of the workflow pass, by stage and command, those of their `*_flags` functions too."""
    texts = [path.read_text(encoding="utf-8") for path in list_rule_files()]
    parts = [part for text in texts for part in re.split(r"^(?=\w)", text, flags=re.MULTILINE)]
    flags = {found[1]: part for part in parts if (found := re.match(r"def (\w+_flags)\(", part))}
    passed = {}
    for part in parts:
        if found := re.search(r'\*\*command\(\s*"(\w+)",\s*"([\w-]+)"', part):
            lines = [part[part.index("    shell:") :], *map(flags.get, re.findall(r"=(\w+_flags),", part))]
            passed[found[1], found[2]] = set(re.findall(r"--[a-z][a-z0-9-]*", "".join(lines)))
    return passed
