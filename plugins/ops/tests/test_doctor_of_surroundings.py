"""What surrounds an installation: a folder that was moved, variables that hide drivers, a client of containers."""

from pathlib import Path

import pytest

from plugins.ops import doctor


def test_an_environment_that_was_moved_is_told(tmp_path: Path) -> None:
    scripts = tmp_path / "new" / ".venv" / "bin"
    scripts.mkdir(parents=True)
    (scripts / "snakemake").write_text(f"#!{scripts}/python\nimport sys\n")
    assert doctor.check_folder(scripts).good
    moved = (tmp_path / "new").rename(tmp_path / "renamed") / ".venv" / "bin"
    found = doctor.check_folder(moved)
    assert not found.good and found.needed and "make setup" in found.fix and str(tmp_path / "new") in found.found


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
