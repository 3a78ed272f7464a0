"""What an edit of a template, a style or a script re-runs."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from roomkin.stages.config import code
from tests.packages import needs

ROOT = Path(__file__).parents[2] / "stages"
PLUGINS = ROOT.with_name("plugins")
FILES = [path for home in (ROOT / "tables", PLUGINS / "report") for path in home.rglob("*")]
DATA = sorted(path.relative_to(ROOT.parent) for path in FILES if path.suffix in code.DATA_SUFFIXES)


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of the package that the digest looks at instead of this one."""
    folder = tmp_path_factory.mktemp("code") / "stages"
    shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(PLUGINS, folder.with_name("plugins"), ignore=shutil.ignore_patterns("__pycache__", "tests"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(code.ROOTS, "roomkin", folder.parent)
        code.forget()
        yield folder
    code.forget()


def digest(command: str) -> str:
    code.forget()
    return code.code_digest(command)


@needs("report")
def test_the_page_has_templates_a_style_and_a_script() -> None:
    assert {path.suffix for path in DATA} == {".jinja", ".mplstyle", ".css", ".js"} and len(DATA) >= 8


@needs("report")
@pytest.mark.parametrize("name", DATA, ids=str)
def test_an_edit_of_a_template_style_or_script_changes_the_digest_of_the_page(copied: Path, name: Path) -> None:
    page = "roomkin.plugins.report.viewer" if "three" in name.parts else "roomkin.plugins.report.report"
    before = {command: digest(command) for command in (page, "roomkin.stages.matching.match")}
    text = (copied.parent / name).read_text()
    (copied.parent / name).write_text(text + "\n")
    try:
        assert digest(page) != before[page]
        assert digest("roomkin.stages.matching.match") == before["roomkin.stages.matching.match"]
    finally:
        (copied.parent / name).write_text(text)
    assert digest(page) == before[page]


@pytest.mark.parametrize("suffix", [".json", ".safetensors", ".csv", ".npz", ".txt"])
def test_other_data_beside_a_module_counts(copied: Path, suffix: str) -> None:
    before, file = digest("roomkin.stages.matching.match"), copied / f"matching/weights{suffix}"
    file.write_text("1")
    try:
        with_file = digest("roomkin.stages.matching.match")
        file.write_text("2")
        assert len({before, with_file, digest("roomkin.stages.matching.match")}) == 3
    finally:
        file.unlink()


def test_a_package_that_imports_all_its_modules_needs_them_and_those_to_come(copied: Path) -> None:
    before = {
        command: digest(command)
        for command in ("roomkin.plugins.furniture.library", "roomkin.stages.extraction.extract")
    }
    new = copied.with_name("plugins") / "furniture/categories/plinths.py"
    new.write_text('"""Plinths."""\n')
    try:
        assert digest("roomkin.plugins.furniture.library") != before["roomkin.plugins.furniture.library"]
        assert digest("roomkin.stages.extraction.extract") == before["roomkin.stages.extraction.extract"]
    finally:
        new.unlink()


@needs("furniture")
def test_who_resizes_models_needs_the_code_of_their_maker() -> None:
    for command in ("roomkin.stages.generation.generate", "roomkin.plugins.scenes.render"):
        assert "roomkin.plugins.furniture.folder" in code.closure(command)


@needs("mujoco")
def test_a_rollout_needs_the_code_of_its_own_simulator() -> None:
    for command in (
        "roomkin.stages.evaluation.selection_rollout",
        "roomkin.stages.evaluation.rollout",
        "roomkin.plugins.scripted.skill",
    ):
        assert len(needed := code.closure(command)) > 20
        assert not [name for name in needed if "mujoco" in name or "mjcf" in name]
    needed = code.closure("roomkin.plugins.mujoco.environment")
    assert "roomkin.plugins.mujoco.mjcf_writer" in needed
    assert not [name for name in needed if name.startswith("roomkin.stages.generation")]


def test_modules_of_a_folder_without_an_init_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own_pack" / "encoders").mkdir(parents=True)
    (tmp_path / "own_pack" / "user.py").write_text("from own_pack.encoders import mine\n")
    (tmp_path / "own_pack" / "encoders" / "mine.py").touch()
    monkeypatch.setitem(code.ROOTS, "own_pack", tmp_path / "own_pack")
    assert code.closure("own_pack.user") == ("own_pack.encoders.mine", "own_pack.user")


def test_jobs_find_packages_where_the_config_found_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own_pack").mkdir()
    (tmp_path / "own_pack" / "__init__.py").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", "elsewhere")
    assert code.path_of_jobs(["own_pack"], tmp_path / "run") == f"elsewhere{os.pathsep}{tmp_path}"
    assert code.path_of_jobs(["own_pack"], tmp_path) == "elsewhere"
