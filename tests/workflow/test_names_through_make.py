"""Names of files and folders reach programs as they were typed, through make and a shell."""

import shlex
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    "name",
    [
        "000048",
        "2024_05_01",
        "frame #3.png",
        "kitchen: first.png",
        "Küche 1.png",
        'it\'s `x` $HOME "q".png',
        "a,b(1).png",
        "кухня (1).jpg",
        "厨房.png",
        "{x}.jpg",
    ],
)
def test_a_name_is_what_was_typed(name: str) -> None:
    planned = subprocess.run(
        ["make", "-n", "--no-print-directory", "picture", f"RGB={name}", f"DEPTH={name}", "INTRINSICS=k.json"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    (line,) = (line for line in planned.splitlines() if " picture " in line)
    words = subprocess.run(
        ["bash", "-c", f"printf '%s\\0' {line.partition(' picture ')[2]}"], capture_output=True, text=True, check=True
    ).stdout
    assert words.split("\0")[:-1] == ["--cores", "2", name, "--depth", name, "--intrinsics", "k.json"]


def test_a_picture_that_is_not_named_is_asked_for_before_anything_runs() -> None:
    done = subprocess.run(["make", "--no-print-directory", "picture"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2 and done.stdout == ""
    assert "error: no picture is named. Fix: make picture RGB=kitchen.jpg" in done.stderr


def test_a_clone_and_a_study_may_lie_in_any_folder(tmp_path: Path) -> None:
    clone, study = tmp_path / "it's my project", tmp_path / "it's my study"
    clone.mkdir()
    for name in ("Makefile", "config", "envs", "pyproject.toml"):
        (clone / name).symlink_to(ROOT / name)
    planned = subprocess.run(
        ["make", "-n", "--no-print-directory", "paper", "registered", "table2", "verify", f"IN={study}"],
        cwd=clone, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    lines = [shlex.split(line) for line in planned.splitlines()]
    assert sum(f"PATH={clone}/.venv/bin:$PATH" in line for line in lines) == 2
    named = [line[line.index(flag) + 1] for line in lines for flag in ("--directory", "--results") if flag in line]
    assert named == ["results/paper", str(study), f"{study}/results", f"{study}/results"]
    subprocess.run(["make", "folder", f"IN={study}"], cwd=clone, check=True)
    assert (study / "config").samefile(clone / "config")
