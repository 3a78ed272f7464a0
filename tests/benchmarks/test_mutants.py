"""Mutants: what is broken, which tests look at it, and what is made of what they say."""

import ast
from pathlib import Path

import pytest

from benchmarks import mutants
from benchmarks.mutants import ROOT, draw, find_tests, judge, list_mutants

CODE = """
def share(a, b):
    # µ: columns count bytes
    print(f"{a + 1}")
    if not a and b > 2:
        raise ValueError("µ" * 3)
    return a / b if b else 0.5
"""
TESTS = """
from roomkin.stages.thing import share

def test_share():
    assert share(3, 2) == 1.5
"""


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """One module and its test."""
    for name, text in (("roomkin/stages/thing.py", CODE), ("test_thing.py", TESTS), ("roomkin/__init__.py", "")):
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    return tmp_path


def test_each_change_is_one_place_and_still_python(repository: Path) -> None:
    found = list(list_mutants(repository / "roomkin/stages/thing.py"))
    changed = {one.apply(CODE) for one in found}
    assert len(changed) == len(found)
    assert CODE not in changed
    assert all(ast.parse(text) for text in changed)
    for words in (
        "b <= 2",
        "a or b",
        "    if (a) and",
        "a * b",
        "(0.5 if b else a / b)",
        "return None",
        "pass",
        "(1.5)",
    ):
        assert sum(words in text for text in changed) >= 1, words
    assert all('print(f"{a + 1}")' in text or "pass\n    if" in text for text in changed), "text is left alone"


def test_the_same_seed_draws_the_same(repository: Path) -> None:
    def names(seed: int) -> list[tuple[int, str]]:
        return [(one.node.lineno, one.text) for one in draw(repository / "roomkin/stages", 5, seed)]

    assert names(1) == names(1) != names(2)
    assert len(names(1)) == 5


def test_tests_are_found_by_imports_and_names() -> None:
    found = find_tests(ROOT)
    first = [path.name for path in found["roomkin.stages.articulated.urdf_tree"][:2]]
    assert first == ["test_articulated.py", "test_malformed_urdf.py"]
    assert "test_matching_encoders.py" in [path.name for path in found["roomkin.stages.matching.descriptors"][:3]]


def test_a_mutant_is_noticed_survives_or_has_no_end(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    by_text = {one.text: one for one in list_mutants(repository / "roomkin/stages/thing.py")}
    seen, unseen = by_text["return None"], by_text["(3)"]
    assert judge(seen, ["test_thing.py"], repository) == "noticed"
    assert judge(unseen, ["test_thing.py"], repository) == "SURVIVED"
    assert judge(seen, [], repository) == "SURVIVED"
    (repository / "test_thing.py").write_text("def test_else():\n    assert False\n")
    assert judge(seen, ["test_thing.py"], repository) == "SURVIVED", "it fails without the mutant, too"
    (repository / "test_thing.py").write_text("def test_else():\n    assert False\n" + TESTS)
    assert judge(seen, ["test_thing.py"], repository) == "noticed", "by another test"
    monkeypatch.setattr(mutants, "LIMIT", 0.01)
    assert judge(seen, ["test_thing.py"], repository) == "NO END"
    assert (repository / "roomkin/stages/thing.py").read_text(encoding="utf-8") == CODE
