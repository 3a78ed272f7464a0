"""A run that is killed goes on by the same command and ends with the same bytes; two in a folder do not begin."""

import shutil
from pathlib import Path

from roomkin.plugins.ops.guard import LOCK
from tests.workflow.kill import KINDS, difference, killed_run
from tests.workflow.workspace import MICRO, copy, make, only_one, snakemake


def test_a_killed_run_goes_on_and_ends_with_the_same_bytes(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    for stage in ("matching/default", "experiment"):
        shutil.rmtree(folder / "results" / stage)
    killed = killed_run(folder, ("matching", "experiment", *MICRO), moments=[1.0, 3.0, 2.0])
    assert killed == list(KINDS)
    assert difference(run / "results", folder / "results") == []


def test_a_folder_that_is_worked_in_is_told_in_a_line_of_its_own(tmp_path: Path) -> None:
    folder = make(tmp_path / "busy")
    (folder / LOCK.parent).mkdir()
    with only_one(folder / LOCK):
        done = snakemake(folder, "library", *MICRO)
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1].startswith("error: ") and done.stdout.endswith("[E-FOLDER-BUSY]\n"), done.stdout
