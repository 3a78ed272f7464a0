"""Who imports whom: folders of `stages/` what comes before them, packages the core, the core no package."""

import ast
import re
from pathlib import Path

from tests.packages import needs

ROOT = Path(__file__).resolve().parents[2]
ORDER = (
    *("geometry", "contracts", "plugins", "articulated", "config", "cli"),
    *("simulation", "planning", "tasks", "skills", "assets", "policies", "perception", "extraction"),
    *("matching", "generation", "demonstrations", "training", "experiment", "evaluation"),
    "tables",
)

ALLOWED_NAMES: list[tuple[str, str]] = []

ON_OTHERS = {  # few, each for a reason
    ("exports", "mujoco"),  # MJCF is MuJoCo's format
    ("exports", "pictures"),  # the same GLB, room and light
    ("api", "films"),  # a policy is filmed
    ("importing", "films"),  # the same way to frame a model
    ("in_scene", "films"),  # its demonstrations are filmed
    ("report", "robustness"),  # and the companion of Table 2
    ("studies", "robustness"),
    ("report", "films"),  # what it shows
    ("report", "in_scene"),
    ("report", "claims"),  # their tables, on the page of a run
    ("studies", "claims"),
    ("studies", "report"),  # the times of a run
    ("annotator", "report"),  # doubts and pictures of models, as pages show them
}


def room_of(module: str) -> str:
    """The room of `roomkin.stages.<room>...`."""
    return module.split(".")[2]


def imports(file: Path) -> set[str]:
    """Modules under `roomkin` that a file imports, inside functions and for types, too."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module in ("roomkin.stages", "roomkin.plugins"):
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add(node.module or "")
    return {name for name in found if name.startswith("roomkin.")}


def edges() -> dict[tuple[str, str], list[str]]:
    """From room to room, and which files import so."""
    found: dict[tuple[str, str], list[str]] = {}
    for file in sorted((ROOT / "stages").rglob("*.py")):
        module = ".".join(["roomkin", *file.relative_to(ROOT).with_suffix("").parts])
        if module == "roomkin.stages.__init__":
            continue
        for name in (name for name in imports(file) if name.startswith("roomkin.stages.")):
            found.setdefault((room_of(module), room_of(name)), []).append(f"{module} imports {name}")
    return found


def test_no_room_imports_upward() -> None:
    found = edges()
    assert {edge: files for edge, files in found.items() if ORDER.index(edge[0]) < ORDER.index(edge[1])} == {}


def test_the_core_imports_no_package() -> None:
    files = sorted((ROOT / "stages").rglob("*.py"))
    found = [(str(file), name) for file in files for name in imports(file)]
    assert [one for one in found if not one[1].startswith("roomkin.stages.")] == []


def test_the_core_names_no_package() -> None:
    """Neither as a module in a string, nor where it asks whether one is on or where one lies."""
    packages = sorted(path.parent.name for path in (ROOT / "plugins").glob("*/package.py"))
    module = re.compile(rf"roomkin\.plugins\.({'|'.join(packages)})(\.\w+)*")
    asked = re.compile(
        rf"""(home_of|command|replacement)\([^)"']*["']({"|".join(packages)})["']"""
        rf"""|packages(\.get\(|\[)\s*["']({"|".join(packages)})["']"""
    )
    found = []
    for file in sorted([*(ROOT / "stages").rglob("*.py"), *(ROOT / "rules").glob("*.smk"), ROOT / "Snakefile"]):
        text = file.read_text(encoding="utf-8")
        found += [(file.name, match[0]) for match in asked.finditer(text)]
        if file.suffix == ".py":
            strings = (node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant))
            found += [(file.name, value) for value in strings if isinstance(value, str) and module.fullmatch(value)]
    assert found == ALLOWED_NAMES


def test_packages_import_no_other() -> None:
    found = []
    for file in sorted((ROOT / "plugins").rglob("*.py")):
        package, *inside = file.relative_to(ROOT).parts[1:]
        others = {name.split(".")[2] for name in imports(file) if name.startswith("roomkin.plugins.")} - {package}
        found += [(package, other) for other in others if "tests" not in inside and (package, other) not in ON_OTHERS]
    assert found == []


def test_every_import_is_seen(tmp_path: Path) -> None:
    text = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from roomkin.stages.a.b import C\n"
    (tmp_path / "m.py").write_text(text + "def f():\n    import roomkin.stages.d\n    from roomkin.stages import e\n")
    assert imports(tmp_path / "m.py") == {"roomkin.stages.a.b", "roomkin.stages.d", "roomkin.stages.e"}


def test_no_module_is_loaded_under_a_second_name() -> None:
    """In a clone `stages` and `plugins` could be imported beside `roomkin.stages` and `roomkin.plugins`."""
    folders = ("roomkin", "stages", "plugins", "rules", "reference", "benchmarks", "tests")
    files = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in (".py", ".smk")]
    second = re.compile(r"^\s*(from|import) (stages|plugins)\b", re.MULTILINE)
    assert len(files) > 600
    assert [path.name for path in files if second.search(path.read_text(encoding="utf-8"))] == []


@needs("report")
def test_no_test_is_left_out_for_a_package_that_is_gone() -> None:
    there = {path.parent.name for path in (ROOT / "plugins").glob("*/__init__.py")}
    for folder in ("tests", "plugins"):
        for file in (ROOT / folder).rglob("*.py"):
            for call in re.findall(r"\bneeds\(([^)]*)\)", file.read_text(encoding="utf-8")):
                assert set(re.findall(r'"(\w+)"', call)) <= there, (file, call)
