"""No test works in the clone, where a run may have left its files."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_a_test_has_a_folder_of_its_own(tmp_path: Path) -> None:
    assert Path.cwd() not in (ROOT, tmp_path) and not list(Path.cwd().iterdir())
    Path("results").mkdir()


def test_no_other_test_sees_what_it_wrote() -> None:
    assert not Path("results").exists()


def test_those_of_packages_have_one_too() -> None:
    assert "own_folder" in (ROOT / "plugins/conftest.py").read_text(encoding="utf-8")
