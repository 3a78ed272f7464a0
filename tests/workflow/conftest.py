"""One micro run of the whole workflow, made once and shared by all workers, in the folder MICRO_RUN if that is set."""

import os
from pathlib import Path

import pytest

from tests.workflow.workspace import MICRO, make, only_one, snakemake


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """A finished run that nobody changes; `workspace.copy` gives one to change."""
    base = tmp_path_factory.getbasetemp()
    shared = base if worker_id == "master" else base.parent
    folder = Path(os.environ.get("MICRO_RUN", shared / "micro"))
    log = folder.with_name("micro.log")
    with only_one(folder.with_name("micro.lock")):
        if not folder.exists():
            done = snakemake(make(folder), "all", *MICRO)
            log.write_text(("" if done.returncode == 0 else "failed\n") + done.stdout)
    assert not log.read_text().startswith("failed"), log.read_text()[-6000:]
    return folder
