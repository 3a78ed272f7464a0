"""A run that is killed goes on by the same command, leaves nothing running and ends with the same bytes."""

import shutil
from pathlib import Path

from tests.workflow.kill import KINDS, difference, killed_run
from tests.workflow.workspace import MICRO, copy


def test_a_killed_run_goes_on_and_ends_with_the_same_bytes(run: Path, tmp_path: Path) -> None:
    folder = copy(run, tmp_path / "run")
    for stage in ("matching/default", "experiment"):
        shutil.rmtree(folder / "results" / stage)
    killed = killed_run(folder, ("matching", "experiment", *MICRO), moments=[1.0, 3.0, 2.0])
    assert killed == list(KINDS)
    assert difference(run / "results", folder / "results") == []
