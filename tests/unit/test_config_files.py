"""A config that is missing or broken, and a target that an option swallowed: one line with file and line."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from roomkin.stages.cli import main
from roomkin.stages.config.__main__ import show
from roomkin.stages.config.files import check, read_file
from roomkin.stages.config.model import read_files
from tests.refusals import refused
from tests.workflow.workspace import ROOT, dry_run, make

BROKEN = [
    ("experiment:\n  rooms: [room_1\n  seeds: [0]\n", "mine.yaml:3: is no YAML", "line 2"),
    ("seed: 1\n\ttask: 2\n", "mine.yaml:2: is no YAML", "no tabs"),
    ("seed: 1\nseed: 2\n", "mine.yaml:2: 'seed' stands in line 1, too", "keep one"),
    ("- seed\n", "mine.yaml: holds a list, no `key: value`", "docs/config.md"),
    ("seed\n", "mine.yaml: holds a value", "docs/config.md"),
    ("", "mine.yaml: is empty", "docs/config.md"),
    ("a: \0", "mine.yaml: is no YAML", ""),
    (b"seed: caf\xe9\n", "mine.yaml: is no UTF-8 text", "UTF-8"),
    ('{"seed": 1', "mine.yaml:1: is no YAML", "line 1"),
]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("text", "says", "fix"), BROKEN)
def test_a_broken_config_is_one_line(
    here: Path, capsys: pytest.CaptureFixture[str], text: str | bytes, says: str, fix: str
) -> None:
    Path("mine.yaml").write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(SystemExit):
        check(["--cores", "2", "--configfile", "mine.yaml", "--", "pages"])
    told = capsys.readouterr().err
    assert told.startswith(f"error: {says}") and fix in told
    assert re.search(r" \[E-[A-Z-]+\]$", told[:-1]) and told.count("\n") == 1


def test_a_config_that_is_not_there_is_told_with_the_nearest_that_is(tmp_path: Path) -> None:
    (tmp_path / "kitchen.yaml").write_text("seed: 1")
    with refused("E-FILE-MISSING", "kitchn.yaml: no such file. Fix: did you mean", "/kitchen.yaml'?"):
        read_file(tmp_path / "kitchn.yaml")
    with refused("E-FILE-MISSING", "Fix: correct the path"):
        read_file(tmp_path / "other.yaml")
    with refused("E-FILE-UNREADABLE"):
        read_file(tmp_path)


@pytest.mark.parametrize(
    ("words", "fix"),
    [
        (["--configfile", "mine.yaml", "pages"], "snakemake --configfile mine.yaml -- pages"),
        (["--config", "seed=1", "pages"], "snakemake --config KEY=VALUE -- pages"),
    ],
)
def test_a_target_that_an_option_swallowed_is_told(
    here: Path, capsys: pytest.CaptureFixture[str], words: list[str], fix: str
) -> None:
    Path("mine.yaml").write_text("seed: 1")
    with pytest.raises(SystemExit):
        check(words)
    told = capsys.readouterr().err
    assert told.startswith("error: pages: ") and f"`{fix}`" in told


@pytest.mark.parametrize("cores", ["0", "-1"])
def test_a_run_of_no_jobs_is_refused(here: Path, capsys: pytest.CaptureFixture[str], cores: str) -> None:
    with pytest.raises(SystemExit):
        check(["all", f"--cores={cores}"])
    assert capsys.readouterr().err.startswith(f"error: --cores {cores}: is no number of jobs")


def test_what_may_be_said_is_no_mistake(here: Path) -> None:
    Path("mine.yaml").write_text("seed: 1")
    Path("tabs.json").write_text('{\n\t"seed": 1\n}')
    check(["all", "--configfile", "mine.yaml", "tabs.json", "--config", "image=a=b.jpg", "--cores", "2", "-n"])
    check(["all", "-c", "-n"])
    check(["--cores", "all"])
    check(["--configfile=mine.yaml", "pages"])
    check(["a", "--configfile=mine.yaml", "b", "--configfile", "mine.yaml", "tabs.json", "-n", "c", "-d", "here"])
    for file in [ROOT / "config.yaml", *(ROOT / "config").rglob("*.yaml")]:
        assert read_file(file)


def test_the_config_of_the_working_directory_is_told_of_as_well(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("there/config").mkdir(parents=True)
    Path("there/config/config.yaml").write_text("seed: [1\n")
    check([])
    with pytest.raises(SystemExit):
        check(["-d", "there"])
    assert "there/config/config.yaml:2: is no YAML" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--configfile", "missing.yaml"), "error: missing.yaml: no such file."),
        (("--configfile", "mine.yaml", "pages"), "error: pages: is no config file"),
    ],
)
def test_snakemake_says_so_in_a_line(tmp_path: Path, words: tuple[str, ...], says: str) -> None:
    folder = make(tmp_path / "clone")
    (folder / "mine.yaml").write_text("seed: 1")
    done = dry_run(folder, *words)
    assert done.returncode == 1 and says in done.stdout, done.stdout
    assert "Traceback" not in done.stdout and len(done.stdout.splitlines()) <= 5, done.stdout


def test_a_snakemake_that_does_not_find_the_package_says_how_to(tmp_path: Path) -> None:
    code = "import sys; sys.modules['roomkin'] = None; from snakemake.cli import main; main(['-n'])"
    folder = make(tmp_path / "clone")
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 1 and "Fix: source .venv/bin/activate" in done.stderr.splitlines()[-1], done.stderr


def test_an_unknown_command_is_told_with_the_nearest(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["tables", "resluts"])
    with pytest.raises(SystemExit):
        main("roomkin.stages.tables", {"results": "...", "report": "..."})
    assert capsys.readouterr().err.startswith(
        "error: roomkin tables has no command 'resluts'. Fix: did you mean 'results'?\n"
    )


def test_a_run_has_the_defaults_of_all_that_its_files_leave_out(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(
        "assets: {counts: {chair: 3, bed: null}}\ntraining: {configs: {lite: {steps: 7}}}\n"
    )
    config = read_files([tmp_path / "mine.yaml"])
    assert (
        config.assets.counts["chair"] == 3 and config.assets.counts["fridge"] > 0 and "bed" not in config.assets.counts
    )
    assert config.training.configs["lite"].steps == 7 and config.training.configs["lite_handle"].handle


def test_every_key_of_a_run_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.yaml").write_text("matching: {k_cat: 5}\n")
    assert show([str(tmp_path / "mine.yaml")]) == 0
    shown = capsys.readouterr().out
    assert "# Nearest categories to search. [>= 1]\n  k_cat: 5\n" in shown
    (tmp_path / "all.yaml").write_text(shown)
    assert read_files([tmp_path / "all.yaml"]) == read_files([tmp_path / "mine.yaml"])
    assert show([str(tmp_path / "none.yaml")]) == 1 and "E-FILE-MISSING" in capsys.readouterr().err


@pytest.mark.parametrize("words", [(), ("show_all",), ("--help",)])
def test_no_reference_is_written_beside_a_clone(tmp_path: Path, words: tuple[str, ...]) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "roomkin.stages.config", *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment)
    asked = words == ("--help",)
    assert done.returncode == (not asked)
    assert (done.stdout if asked else done.stderr).startswith("`roomkin config`: ")
    assert not list(tmp_path.iterdir())
