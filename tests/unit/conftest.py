"""A valid file of every kind, for tests that break them."""

import shutil
from pathlib import Path

import pytest

from tests.unit.contract_files import Bench, write_files


@pytest.fixture(scope="session")
def valid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_files(tmp_path_factory.mktemp("valid"))


@pytest.fixture
def bench(valid: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Bench:
    shutil.copytree(valid, tmp_path / "run")
    return Bench(tmp_path / "run", capsys)
