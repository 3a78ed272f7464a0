"""What surrounds an installation: a folder that was moved, variables that hide drivers, a client of containers."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from roomkin.plugins.ops import doctor

TOOL = """
from setuptools import setup
setup(name="tool", version="1", py_modules=["tool"], entry_points={"console_scripts": ["snakemake=tool:main"]})
"""


def install(folder: Path, source: Path) -> Path:
    """An environment with a script called snakemake, as `make setup` makes one; its scripts."""
    python = folder / ".venv" / "bin" / "python"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / ".venv"], check=True)
    uv = [Path(sys.executable).with_name("uv"), "pip", "install", "--quiet", "--offline", "--no-deps"]
    subprocess.run([*uv, "--python", python, source], check=True)
    return python.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A package of one script."""
    folder = tmp_path_factory.mktemp("tool")
    (folder / "setup.py").write_text(TOOL)
    (folder / "tool.py").write_text("def main(): print('it ran')\n")
    make = [sys.executable, "setup.py", "--quiet", "bdist_wheel"]
    subprocess.run(make, cwd=folder, check=True, capture_output=True)
    return next(folder.glob("dist/*.whl"))


@pytest.mark.parametrize("name", ["plain", "my projects", "it's", "long" * 40])
def test_an_environment_is_told_only_if_it_was_moved_or_copied(name: str, wheel: Path, tmp_path: Path) -> None:
    scripts = install(tmp_path / name, wheel)
    assert subprocess.check_output([scripts / "snakemake"], text=True) == "it ran\n"
    assert doctor.check_folder(scripts).good
    copied = shutil.copytree(tmp_path / name, tmp_path / "copy", symlinks=True) / ".venv" / "bin"
    found = doctor.check_folder(copied)
    assert not found.good and found.needed and "make setup" in found.fix
    assert f"made in {tmp_path / name / '.venv'}, and moved or copied" in found.found
    moved = (tmp_path / name).rename(tmp_path / "moved") / ".venv" / "bin"
    assert not doctor.check_folder(moved).good and "made elsewhere" in doctor.check_folder(copied).found


def test_a_variable_that_hides_the_drivers_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_probe", lambda code: "")
    monkeypatch.setenv("VK_ICD_FILENAMES", str(tmp_path / "gone.json"))
    found = doctor.check_vulkan()
    assert "gone.json" in found.found and found.fix == "unset VK_ICD_FILENAMES"
    assert doctor.mend_check(doctor.check_vulkan).fix == "unset VK_ICD_FILENAMES", "no driver is installed for it"
    monkeypatch.delenv("VK_ICD_FILENAMES")
    assert "vulkan.sh" in doctor.check_vulkan().fix


def test_a_client_without_its_service_runs_no_containers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    for name, code in (("docker", 1), ("podman", 0)):
        (tmp_path / name).write_text(f"#!/bin/sh\nexit {code}\n")
        (tmp_path / name).chmod(0o755)
    assert doctor.check_containers().found == "podman, docker (installed, but nothing answers)"
    (tmp_path / "podman").unlink()
    assert not doctor.check_containers().good


@pytest.mark.parametrize(("argument", "code", "words"), [("--help", 0, "--mend"), ("--fix", 2, "there is no --fix")])
def test_arguments_are_looked_at_before_the_machine(
    argument: str, code: int, words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor, "checks", lambda mend: pytest.fail("nothing is checked"))
    assert doctor.main([argument]) == code and words in capsys.readouterr().out


def test_drivers_are_tried_again_once_the_environment_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def say(*arguments: str) -> tuple[int, int, str]:
        """Exit code, how often drivers were tried, and what is printed."""
        before = len(tried)
        return doctor.main([*arguments]), len(tried) - before, capsys.readouterr().out

    tried: list[bool] = []
    driver = doctor.Check("vulkan", True, "a device")
    monkeypatch.setattr(doctor, "checks", lambda mend: tried.append(mend) or [driver])
    monkeypatch.setattr(doctor, "quick_checks", lambda: [doctor.Check("python", True, "3.11"), disk])
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    disk = doctor.Check("disk", True, "60 GB free")
    assert say("--brief")[:2] == say("--brief")[:2] == (0, 1), "nothing tells whether it has changed"
    (tmp_path / ".installed").touch()
    assert say("--mend", "--brief") == (0, 1, "ok   vulkan      a device\n")
    assert say("--mend", "--brief") == (0, 0, ""), "a second `make` says nothing"
    disk = doctor.Check("disk", False, "1 GB free", "free 5 GB")
    assert say("--mend", "--brief") == (1, 0, "MISS disk        1 GB free\n     fix: free 5 GB\n")
    disk = doctor.Check("disk", True, "60 GB free")
    assert say("--mend")[:2] == say()[:2] == (0, 1), "`make setup` and `make check` always try"
    monkeypatch.setenv("VK_DRIVER_FILES", "mine.json")
    assert say("--brief")[1] == 1
    driver = doctor.Check("vulkan", False, "no device")
    os.utime(tmp_path / ".installed", (0, 0))  # `make setup` has changed it
    assert say("--brief")[:2] == say("--brief")[:2] == (1, 1), "what lacks is told until it is there"
