"""docs/commands.md: every command and its flags, as the code has them."""

import ast
import keyword
import re
from collections.abc import Iterator
from dataclasses import dataclass
from inspect import cleandoc
from pathlib import Path

HEAD = """\
# Commands

This page is written from the code by `make reference`.

## make

| target | what it does |
|---|---|
"""
VERBS = """
## Verbs

A stage is a command, `python -m stages.<stage> <verb> --flag value`, a package beside the core
`python -m plugins.<package> <verb> --flag value`; `--help` prints what stands here. Flags without
a default must be given. `--options` is JSON of the stage's section of the [config](config.md). The workflow passes the
flags marked x, also to a command of yours that [replaces a verb](extending.md#replace-a-verb-or-a-stage).
"""


@dataclass(frozen=True)
class Flag:
    """One flag of a verb; `default` is None if it must be given."""

    name: str
    default: str | None
    meaning: str


@dataclass(frozen=True)
class Verb:
    """One verb of a stage and what its docstring says."""

    stage: str
    name: str
    summary: str
    flags: list[Flag]


def verbs(root: Path) -> Iterator[Verb]:
    """All verbs of all stages, then of the packages, in the order of their `__main__.py`."""
    for path in [file for folder in ("stages", "plugins") for file in sorted((root / folder).glob("*/__main__.py"))]:
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and len(call.args) == 2 and isinstance(call.args[1], ast.Dict):
                for name, summary in ast.literal_eval(call.args[1]).items():  # main("matching", {"match": ...})
                    yield verb(path.parent / module_of(name), path.parent.name, name, summary)


def module_of(name: str) -> str:
    """The file of a verb, as `stages.cli` finds it."""
    return name.replace("-", "_") + "_" * keyword.iskeyword(name) + ".py"


def verb(file: Path, stage: str, name: str, summary: str) -> Verb:
    """A verb, read from the function `run` of its module."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    run = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "run")
    meaning = arguments(ast.get_docstring(run) or "")
    flags = [Flag(each.arg.upper(), None, meaning.get(each.arg, "")) for each in run.args.posonlyargs]
    for each, default in zip(run.args.kwonlyargs, run.args.kw_defaults, strict=True):
        text = None if default is None else ast.unparse(default)
        flags.append(Flag("--" + each.arg.replace("_", "-"), text, meaning.get(each.arg, "")))
    return Verb(stage, name, summary, flags)


def arguments(docstring: str) -> dict[str, str]:
    """Texts of the section `Args` by argument."""
    _, _, section = cleandoc(docstring).partition("\nArgs:\n")
    section = re.split(r"\n\n\w+:\n", section)[0]
    found = re.split(r"^    (\w+): ", section, flags=re.MULTILINE)[1:]
    return {name: " ".join(text.split()) for name, text in zip(found[::2], found[1::2], strict=True)}


def rule_files(root: Path) -> list[Path]:
    """The files of rules, of the core and of the packages."""
    return [*sorted((root / "rules").glob("*.smk")), *sorted((root / "plugins").glob("*/*.smk"))]


def list_passed_flags(root: Path) -> dict[str, set[str]]:
    """The flags that the rules of the workflow pass, by `stage verb`, those of their `*_flags` functions among them."""
    texts = [path.read_text(encoding="utf-8") for path in rule_files(root)]
    parts = [part for text in texts for part in re.split(r"^(?=\w)", text, flags=re.MULTILINE)]
    flags = {found[1]: part for part in parts if (found := re.match(r"def (\w+_flags)\(", part))}
    called = {}
    for part in parts:
        if found := re.search(r'\*\*verb\(\s*"(\w+)",\s*"([\w-]+)"', part):
            lines = [part[part.index("    shell:") :], *map(flags.get, re.findall(r"=(\w+_flags),", part))]
            called[f"{found[1]} {found[2]}"] = set(re.findall(r"--[a-z][a-z0-9-]*", "".join(lines)))
    return called


def targets(root: Path) -> Iterator[tuple[str, str]]:
    """Targets of the Makefile and what they do."""
    yield from re.findall(r"^([\w-]+):[^#\n]*## (.*)$", (root / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)


def page(root: Path) -> str:
    """The text of docs/commands.md."""
    lines = [HEAD + "\n".join(f"| `make {name}` | {text} |" for name, text in targets(root)), VERBS]
    called = list_passed_flags(root)
    for each in verbs(root):
        ours = called.get(f"{each.stage} {each.name}", set())
        lines += [f"### `{each.stage} {each.name}`", "", each.summary[:1].upper() + each.summary[1:] + ".", ""]
        lines += ["| flag | default | workflow | meaning |", "|---|---|---|---|"]
        for flag in each.flags:
            default = "" if flag.default is None else f"`{flag.default}`"
            mark = "x" if flag.name in ours else ""
            meaning = flag.meaning.replace("|", "\\|").replace("<", "&lt;")
            lines.append(f"| `{flag.name}` | {default} | {mark} | {meaning} |")
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"
