"""A SLURM cluster on this machine for the tests of one file, and one finished micro run."""

import os
from collections.abc import Iterator

import pytest

from tests.cluster.slurm import Cluster, missing, running
from tests.workflow.conftest import run

__all__ = ["run"]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    """Two idle nodes."""
    if lacking := missing():
        pytest.skip(f"not installed here: {', '.join(lacking)}")
    if os.geteuid() != 0:
        pytest.skip("the daemons of SLURM need root")
    with running() as cluster:
        yield cluster
