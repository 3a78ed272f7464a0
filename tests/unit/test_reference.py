"""The page and pictures that are read off the code are up to date; nothing imports upward."""

from itertools import pairwise
from pathlib import Path

import networkx as nx
import pytest

from reference import rooms
from reference.__main__ import generate
from tests.packages import needs

pytestmark = needs("exports", "importing", "report", "annotator")  # pages are written from all packages

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def written() -> dict[str, str]:
    return generate(ROOT)


@pytest.mark.parametrize("name", ["docs/architecture.md", "docs/images/data.svg", "docs/images/rooms.svg"])
def test_what_is_committed_is_what_the_code_says(written: dict[str, str], name: str) -> None:
    assert (ROOT / name).read_text(encoding="utf-8") == written[name], "run `make reference`"


def test_nothing_imports_upward() -> None:
    graph = rooms.imports(ROOT)
    circles = [
        [(*edge, graph.edges[edge]["files"]) for edge in pairwise([*circle, circle[0]])]
        for circle in nx.simple_cycles(graph)
    ]
    assert circles == []


def test_every_section_of_the_appendix_that_has_code_is_found(written: dict[str, str]) -> None:
    rows = dict(
        line.split(" | ")[::2] for line in written["docs/architecture.md"].splitlines() if line[:4] in ("| A.", "| B.")
    )
    assert list(rows) == [
        f"| {name}" for name in ("A.1", "A.2", "A.3", "A.4", "A.5", "A.6", "A.7", "B.1", "B.3", "B.4")
    ]
    assert "stages/generation/stacking.py: `assign_supports`" in rows["| A.3"]
