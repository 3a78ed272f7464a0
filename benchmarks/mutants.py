"""Do the tests see what is broken? `python -m benchmarks.mutants --seed 1 --count 20 [--folder stages/matching]`.

Breaks one place of one function at a time, in a copy of the repository, runs the test files that import its module,
and prints what none of them noticed. The same seed draws the same places of the same code.
"""

import argparse
import ast
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from roomkin.stages.config.code import ROOTS, closure

ROOT = Path(__file__).resolve().parents[1]
LIMIT = 300  # seconds for the tests of one mutant, also beside other work
NO_TESTS = 5  # what pytest returns if it ran none
MOST = 5  # test files for a mutant: the nearest
FLIPPED = {ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
           ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is}  # fmt: skip
SWAPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
FAILED = re.compile(r"^FAILED (\S+?)(?: - .*)?$", re.MULTILINE)


class Mutant(NamedTuple):
    """One node of a module in the place of another; both are of the same span of its text."""

    path: Path
    node: ast.expr | ast.stmt
    text: str

    def apply(self, source: str) -> str:
        """The text of the module with the change."""
        lines = source.encode().splitlines(keepends=True)  # columns are counted in bytes
        node = self.node
        assert node.end_lineno is not None and node.end_col_offset is not None
        before = b"".join(lines[: node.lineno - 1]) + lines[node.lineno - 1][: node.col_offset]
        after = lines[node.end_lineno - 1][node.end_col_offset :] + b"".join(lines[node.end_lineno :])
        return (before + self.text.encode() + after).decode()


def change(node: ast.AST) -> str | None:
    """The text of a node that means something else; None: this kind is left alone."""
    match node:
        case ast.Compare(left=left, ops=[op], comparators=right) if type(op) in FLIPPED:
            return f"({ast.unparse(ast.Compare(left, [FLIPPED[type(op)]()], right))})"
        case ast.BoolOp(op=op, values=values):
            return f"({ast.unparse(ast.BoolOp(ast.Or() if isinstance(op, ast.And) else ast.And(), values))})"
        case ast.BinOp(left=left, op=op, right=right) if type(op) in SWAPPED:
            return f"({ast.unparse(ast.BinOp(left, SWAPPED[type(op)](), right))})"
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return f"({ast.unparse(operand)})"
        case ast.IfExp(test=test, body=body, orelse=orelse):
            return f"({ast.unparse(ast.IfExp(test, orelse, body))})"
        case ast.Constant(value=bool(value)):
            return str(not value)
        case ast.Constant(value=int(value) | float(value)):
            return f"({value + 1})"
        case ast.Return(value=value) if value is not None and not isinstance(value, ast.Constant):
            return "return None"
        case ast.Expr(value=ast.Call()) | ast.Raise():
            return "pass"
    return None


def list_mutants(path: Path) -> Iterator[Mutant]:
    """All changes inside the functions of a module."""
    for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(function, ast.FunctionDef):
            texts = [each for each in ast.walk(function) if isinstance(each, ast.JoinedStr)]
            quoted = {id(part) for each in texts for part in ast.walk(each)}
            for statement in function.body:
                for node in ast.walk(statement):
                    text = None if id(node) in quoted else change(node)
                    if text and isinstance(node, ast.expr | ast.stmt):
                        yield Mutant(path, node, text)


def draw(folder: Path, count: int, seed: int) -> list[Mutant]:
    """So many of all changes in a folder, each place once, evenly over them."""
    found = [one for path in sorted(folder.rglob("*.py")) for one in list_mutants(path)]
    once = {(one.path, one.node.lineno, one.node.col_offset, one.text): one for one in found}  # of nested functions
    return random.Random(seed).sample(list(once.values()), min(count, len(once)))


def find_tests(root: Path) -> dict[str, list[Path]]:
    """Test files by module that they reach. First come those that import it themselves, replace what is in it or share
    words of its name, then those that reach least else. Tests of whole workflows are left out."""
    ROOTS["tests"] = root / "tests"
    found: dict[str, list[tuple[int, int, Path]]] = {}
    for path in sorted([*(root / "tests/unit").rglob("test_*.py"), *root.glob("roomkin/plugins/*/tests/test_*.py")]):
        name, text = ".".join(path.relative_to(root).with_suffix("").parts), path.read_text(encoding="utf-8")
        words, reached = set(path.stem.split("_")), closure(name)
        for module in reached:
            named = f"{module} import" in text or f'"{module}.' in text
            nearness = named + len(words.intersection(re.split(r"[._]", module)))
            found.setdefault(module, []).append((-nearness, len(reached), path))
    return {module: [path for *_, path in sorted(files)] for module, files in found.items()}


def run_tests(copy: Path, tests: list[str]) -> str | None:
    """What pytest says of tests in a copy of the repository up to the first that fails; "": none does; None: no end."""
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", *tests]
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    job = subprocess.Popen(
        command, cwd=copy, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        said, _ = job.communicate(timeout=LIMIT)
        return "" if job.returncode in (0, NO_TESTS) else said
    except subprocess.TimeoutExpired:
        os.killpg(job.pid, signal.SIGKILL)
        job.communicate()
        return None


def judge(mutant: Mutant, tests: list[str], copy: Path) -> str:
    """What tests make of a mutant, in a copy of the repository: what fails there without it does not notice it."""
    changed = copy / mutant.path.relative_to(ROOT)
    source = changed.read_text(encoding="utf-8")
    changed.write_text(mutant.apply(source), encoding="utf-8")
    said = run_tests(copy, tests) if tests else ""
    changed.write_text(source, encoding="utf-8")
    if said is None:
        return "NO END"
    failed = FAILED.findall(said)
    if failed and run_tests(copy, failed):
        return judge(mutant, [*tests, *(f"--deselect={name}" for name in failed)], copy)
    return "noticed" if said else "SURVIVED"


def main() -> None:
    """Draw mutants, try each, print what survived."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("stages"))
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    tests, counts = find_tests(ROOT), Counter[str]()
    with tempfile.TemporaryDirectory(prefix="mutants-") as place:
        tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        for name in tracked.split("\0")[:-1]:
            Path(place, name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, Path(place, name), follow_symlinks=False)
        for mutant in draw(ROOT / asked.folder, asked.count, asked.seed):
            where = mutant.path.relative_to(ROOT)
            near = tests.get(".".join(["roomkin", *where.with_suffix("").parts]).removesuffix(".__init__"), [])[:MOST]
            found = judge(mutant, [str(path.relative_to(ROOT)) for path in near], Path(place))
            counts[found] += 1
            old = " ".join(ast.unparse(mutant.node).split())
            print(f"{found:<8} {where}:{mutant.node.lineno} {old[:100]} -> {mutant.text[:100]}", flush=True)
    print(f"{counts['noticed']} of {counts.total()} noticed, {counts['NO END']} without an end in {LIMIT} s")


if __name__ == "__main__":
    main()
