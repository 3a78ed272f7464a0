"""docs/errors.md: every code of an `InputError`, what it says and how to mend it, as the calls in the code have it."""

import ast
import html
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

INTRODUCTION = """\
# Errors

A command that cannot use what it was given ends with exit code 1 and one line:

    error: where: what is wrong. Fix: how to mend it [CODE]

The words may change from release to release; the code stays. Below, `{name}` stands for a value.
What is only [doubted](#doubts) comes last. This page is written from the code by `make reference`.
"""


DEFAULTS = {"InputError": "E-INPUT", "Mistake": "E-CONFIG-CLASH"}  # codes of what is made without one


class Fault(NamedTuple):
    """One place that raises an error; `code` is empty if it has none, or takes that of another error."""

    code: str
    file: str
    line: int
    says: str
    fix: str


def faults(root: Path, folders: tuple[str, ...] = ("stages", "plugins")) -> list[Fault]:
    """Every call that makes an error in the Python files below some folders of the repository, by code and file."""
    paths = [file for folder in folders for file in sorted((root / folder).rglob("*.py"))]
    files = [file for file in paths if "tests" not in file.relative_to(root).parts]
    modules = {file.relative_to(root).with_suffix(""): ast.parse(file.read_text(encoding="utf-8")) for file in files}
    constants = {".".join(name.parts): _assigned(tree.body) for name, tree in modules.items()}
    found = [fault for name, tree in modules.items() for fault in _faults_of(tree, f"{name}.py", constants)]
    return sorted(found, key=lambda fault: (fault.code, fault.file, fault.line))


def page(root: Path) -> str:
    """The text of docs/errors.md."""
    coded = [fault for fault in faults(root) if fault.code]
    parts = [INTRODUCTION]
    for code, same in groupby(coded, key=lambda fault: fault.code):
        lines = [f"* `{fault.says}`{_mend(fault.fix)} ({fault.file})" for fault in same]
        parts.append("\n".join([f"## {code}", "", *dict.fromkeys(lines)]) + "\n")
    return "\n".join(parts)


Values = Mapping[str, list[ast.expr]]  # what is assigned to a name


def _assigned(nodes: Iterable[ast.AST]) -> dict[str, list[ast.expr]]:
    """What some statements assign to names."""
    found = defaultdict(list)
    for each in nodes:
        if isinstance(each, ast.Assign) and isinstance(each.targets[0], ast.Name):
            found[each.targets[0].id].append(each.value)
    return found


def _faults_of(tree: ast.Module, name: str, constants: Mapping[str, Values]) -> Iterator[Fault]:
    """Those of a file; `constants`: what the modules of the repository assign to names, by module."""
    imported = {
        alias.asname or alias.name: constants.get(each.module or "", {}).get(alias.name, [])
        for each in ast.walk(tree)
        if isinstance(each, ast.ImportFrom)
        for alias in each.names
    }
    shared = imported | _assigned(tree.body)
    known = dict.fromkeys(ast.walk(tree), shared)
    for function in [each for each in known if isinstance(each, ast.FunctionDef)]:  # inner ones after those around them
        names = shared | {key: [] for key in _parameters(function)} | _assigned(ast.walk(function))
        known |= dict.fromkeys(ast.walk(function), names)
    for call, names in known.items():
        if not isinstance(call, ast.Call):
            continue
        given = dict(zip(("where", "what", "fix", "code"), call.args, strict=False))
        given |= {word.arg: word.value for word in call.keywords if word.arg}
        code, default = given.get("code"), DEFAULTS.get(ast.unparse(call.func))
        holders = names.get(code.id, []) if isinstance(code, ast.Name) else [code] if code else []
        codes = [each for holder in holders for each in _codes(holder)]
        if codes or default:
            parts = (_said(given.get(part), names, call.lineno) for part in ("where", "what", "fix"))
            where, what, fix = (text.replace("`", "'") for text in parts)
            says = what if where.startswith("{") else f"{where}: {what}"  # a path that is only known when it runs
            for each in codes or ["" if code or not default else default]:
                yield Fault(each, name, call.lineno, says, fix)


def _parameters(function: ast.FunctionDef) -> list[str]:
    return [each.arg for each in (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)]


def _said(node: ast.expr | None, known: Values, line: int) -> str:
    """What an expression says; of a name the text that was assigned to it last, if that is known before it runs."""
    if isinstance(node, ast.Name):
        values = known.get(node.id, [])
        values = [value for value in values if value.lineno <= line] or values
        text = "".join(_text(value) for value in values[-1:])
        return _text(node) if not text or text.startswith("{") else text
    if isinstance(node, ast.IfExp):
        return " | ".join(filter(None, (_said(node.body, known, line), _said(node.orelse, known, line))))
    return _text(node)


def _codes(node: ast.expr) -> list[str]:
    """The codes that an expression may give: of `"E-A" if here else "E-B"` both; none that it takes from elsewhere."""
    texts = [each.value for each in ast.walk(node) if isinstance(each, ast.Constant) and isinstance(each.value, str)]
    return [text for text in texts if text.startswith("E-")]


def _text(node: ast.expr | None) -> str:
    """What an expression says, with `{name}` for what is only known when it runs."""
    match node:
        case None:
            return ""
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(map(_text, parts))
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _text(left) + _text(right)
        case ast.IfExp(body=one, orelse=other):
            return " | ".join(filter(None, (_text(one), _text(other))))
        case ast.FormattedValue(value=value):
            return _text(value)
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return f"{{{name}}}"
    return "{...}"


def _mend(fix: str) -> str:
    return " Fix: " + re.sub(r"([*_|\\[\]])", r"\\\1", html.escape(fix, quote=False)) if fix else ""
