"""The Snakemake command that a page tells works where it is typed: in a clone, outside of it, and without one."""

from pathlib import Path

import pytest

from roomkin.stages.perception import write


def test_a_command_fits_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    home = tmp_path / "it is"
    home.mkdir()
    monkeypatch.setattr(write, "PACKAGES", home / "plugins")
    assert write.to_run("-- pages") == f"snakemake --snakefile '{home}/Snakefile' -- pages"  # as pip installs it
    (home / "pyproject.toml").touch()
    assert write.to_run("-- pages") == f"cd '{home}' && snakemake -- pages"
    Path("results").mkdir()  # what is made again is here, as `roomkin picture` left it
    assert write.to_run("-- pages") == f"snakemake --snakefile '{home}/Snakefile' -- pages"
    Path("Snakefile").touch()
    assert write.to_run("-- pages") == "snakemake -- pages"
