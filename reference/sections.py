"""Where each section of the paper's appendix is: files and functions whose first line names it."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

SECTION = re.compile(r"\b[AB]\.\d\b")
ABOUT = {
    "A.1": "assets, snapshots", "A.2": "from image to objects", "A.3": "placing, walls, supports, collisions",
    "A.4": "skills, grasps, planning", "A.5": "initial states, demonstrations", "A.6": "matching by patches",
    "A.7": "clouds, counts, orientation, sizes", "B.1": "Table 2", "B.3": "policies, observations",
    "B.4": "tasks, Table 3",
}  # fmt: skip


def table(root: Path) -> str:
    """Markdown: a row for each section, with what follows it."""
    found: dict[str, list[str]] = {}
    for folder in ("stages", "plugins"):
        for file in sorted((root / folder).rglob("*.py")):
            if "tests" not in file.parts and "config" not in file.parts:
                for name, line in _cited_in(file):
                    for section in dict.fromkeys(SECTION.findall(line)):
                        path = file.parent if file.name == "__init__.py" else file
                        place = f"{path.relative_to(root).as_posix()}{f': `{name}`' if name else ''}"
                        found.setdefault(section, []).append(place)
    rows = (f"| {section} | {ABOUT.get(section, '')} | {'<br>'.join(found[section])} |" for section in sorted(found))
    return "\n".join(["| section | about | where |", "|---|---|---|", *rows])


def _cited_in(file: Path) -> Iterator[tuple[str, str]]:
    """Names of functions and classes, "" of the file itself, whose docstring's first line names a section, and it."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef) and (text := ast.get_docstring(node)):
            name = "" if isinstance(node, ast.Module) else node.name
            if SECTION.search(line := text.splitlines()[0]) and not name.startswith("_"):
                yield name, line
