"""Which image Snakemake asks apptainer to run for a rule: by a program of that name that writes it down."""

import os
from pathlib import Path

from roomkin.stages.config.files import ContainersConfig
from tests.workflow.workspace import make, overlay, snakemake

STUB = """#!/bin/bash
# `apptainer --version`, and `apptainer exec ... IMAGE.sif bash -c COMMAND`, which it runs here.
[ "$1" = --version ] && { echo apptainer version 1.3.0; exit; }
while [ "${1##*.}" != sif ]; do shift; done
echo "$1" >> asked
shift
exec "$@"
"""


def test_a_rule_is_run_in_the_image_of_its_family(tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    images = [ContainersConfig().simulation]
    for name in images:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).touch()
    programs = tmp_path / "programs"
    programs.mkdir()
    (programs / "apptainer").write_text(STUB)
    (programs / "apptainer").chmod(0o755)
    config = overlay(folder, "{assets: {counts: {mug: 2}}, experiment: {targets: {door: null}}}")
    path = f"{programs}:{os.environ['PATH']}"
    done = snakemake(folder, *config, "--profile", "profiles/apptainer", "--", "library", environment={"PATH": path})
    assert done.returncode == 0, done.stdout
    asked = {Path(line).name for line in (folder / "asked").read_text().splitlines()}
    assert asked == {Path(images[0]).name}
