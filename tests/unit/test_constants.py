"""A number that stands for a decision says what it is: its unit, and where it is from."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("stages/extraction", "stages/generation", "stages/matching", "plugins/render_and_compare")
FILES = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py") if "tests" not in path.parts)


def find_bare_numbers(text: str) -> Iterator[str]:
    """Names of module constants in capitals that are numbers, or rows of them, without a comment on or above them."""
    lines = text.splitlines()
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            target = ast.unparse(node.targets[0] if isinstance(node, ast.Assign) else node.target)
            parts = list(ast.walk(node.value))
            is_text = any(isinstance(part, ast.Constant) and isinstance(part.value, str) for part in parts)
            is_number = any(isinstance(part, ast.Constant) and isinstance(part.value, int | float) for part in parts)
            own, above = lines[node.lineno - 1 : node.end_lineno], lines[node.lineno - 2] if node.lineno > 1 else ""
            is_told = any("#" in line for line in own) or above.startswith("#")
            if target.isupper() and is_number and not is_text and not is_told:
                yield target


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_numbers_say_what_they_are(path: Path) -> None:
    assert list(find_bare_numbers(path.read_text())) == []


def test_bare_numbers_are_found() -> None:
    text = "A = 3\n\nB = 0.5  # metres\nI = 4\n\n# Pixels.\nC, D = 1, 2\n\nE, F = (1, 2), 3\n\nG = ('a', 3)\n\nh = 3\n"
    assert list(find_bare_numbers(text)) == ["A", "I", "(E, F)"]
