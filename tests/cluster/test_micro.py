"""The smallest run of everything on SLURM, beside a local one."""

from pathlib import Path

import pytest

from tests.cluster.slurm import Cluster
from tests.cluster.workflow import said, start
from tests.workflow.kill import difference
from tests.workflow.workspace import MICRO, make

pytestmark = pytest.mark.cluster


def test_a_run_on_slurm_ends_with_the_bytes_of_a_local_one(cluster: Cluster, run: Path, tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    assert start(cluster, folder, "all", *MICRO).wait() == 0, said(folder)[-5000:]
    assert difference(run / "results", folder / "results") == []
    assert cluster.queue() == []
    submitted = said(folder).count("has been submitted with SLURM jobid")
    assert submitted <= 16, f"{submitted} submissions for the micro run"
