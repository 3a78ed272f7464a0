"""Pages and pictures that are read off the code are up to date; every error has a code; nothing imports upward."""

import re
from itertools import pairwise
from pathlib import Path

import networkx as nx
import pytest

from reference import doubts, errors, pages, rooms
from stages.contracts.doubt import DoubtKind
from tests.packages import needs

pytestmark = needs("exports", "importing", "inputs", "report", "studio")  # pages are written from all packages

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def written() -> dict[str, str]:
    return pages.generate(ROOT)


@pytest.mark.parametrize(
    "name",
    ["docs/architecture.md", "docs/commands.md", "docs/errors.md", "docs/images/data.svg", "docs/images/rooms.svg"],
)
def test_what_is_committed_is_what_the_code_says(written: dict[str, str], name: str) -> None:
    assert (ROOT / name).read_text(encoding="utf-8") == written[name], "run `make reference`"


def test_every_error_has_a_code() -> None:
    assert [fault for fault in errors.faults(ROOT) if fault.code == "E-INPUT"] == []


def test_every_code_has_its_place_on_the_page(written: dict[str, str]) -> None:
    files = [file for folder in ("stages", "plugins") for file in (ROOT / folder).rglob("*.py")]
    codes = {code for file in files for code in re.findall(r'"(E-[A-Z-]+)"', file.read_text(encoding="utf-8"))}
    headings = re.findall(r"^## (E-.*)$", written["docs/errors.md"], re.MULTILINE)
    assert len(headings) > 100 and set(headings) == codes - {"E-INPUT"}


def test_every_doubt_is_declared_once() -> None:
    assert len({kind.code for kind in DoubtKind}) == len(DoubtKind)
    texts = {path: path.read_text(encoding="utf-8") for path in (ROOT / "stages").rglob("*.py")}
    assert [path.name for path, text in texts.items() if re.search(r"\bDoubt\(cause", text)] == ["doubt.py"]
    rows = re.findall(r"^\| D-.*$", doubts.section(ROOT), re.MULTILINE)
    assert len(rows) == len(DoubtKind) and all(re.search(r"(stages|plugins)/", row) for row in rows), (
        "a doubt that nobody has"
    )


def test_nothing_imports_upward() -> None:
    graph = rooms.imports(ROOT)
    circles = [
        [(*edge, graph.edges[edge]["files"]) for edge in pairwise([*circle, circle[0]])]
        for circle in nx.simple_cycles(graph)
    ]
    assert circles == []


CODE = """
raise InputError(path, f"has {len(links)} links in '{path.name}'.", "at most 9", code="E-LINKS-MANY")
raise InputError("depth.npz", "is no " + what, fix, "E-DEPTH-A" if flat else "E-DEPTH-B")
raise InputError(path, "is bad.")
raise InputError(path, str(error), code=error.code)
refuse(path, "is locked.", code="E-LINKS-MANY")
code = "E-KEY"
Mistake("task.points", "is no key", code=code)
Mistake("task.points", "is too many")
MEND = "make it again"
def check(fix, what):
    raise InputError(path, what, fix, code="E-TOLD")
def other():
    what = "is too old."
    raise InputError(path, what, MEND, code="E-TOLD")
"""


def test_errors_are_read_from_their_calls(tmp_path: Path) -> None:
    (tmp_path / "stages").mkdir()
    (tmp_path / "stages/one.py").write_text(CODE)
    assert [(fault.code, fault.says, fault.fix) for fault in errors.faults(tmp_path)] == [
        ("", "{...}", ""),
        ("E-CONFIG-CLASH", "task.points: is too many", ""),
        ("E-DEPTH-A", "depth.npz: is no {what}", "{fix}"),
        ("E-DEPTH-B", "depth.npz: is no {what}", "{fix}"),
        ("E-INPUT", "is bad.", ""),
        ("E-KEY", "task.points: is no key", ""),
        ("E-LINKS-MANY", "has {...} links in '{name}'.", "at most 9"),
        ("E-LINKS-MANY", "is locked.", ""),
        ("E-TOLD", "{what}", "{fix}"),
        ("E-TOLD", "is too old.", "make it again"),
    ]
    last = ["## E-LINKS-MANY", "", "* `has {...} links in '{name}'.` Fix: at most 9 (stages/one.py)"]
    assert "\n".join([*last, "* `is locked.` (stages/one.py)"]) in errors.page(tmp_path)
