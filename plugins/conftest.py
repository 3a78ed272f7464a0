"""Fixtures that tests of packages share with those of the core."""

from tests.conftest import own_folder, shared_folder
from tests.unit.conftest import bench, valid
from tests.workflow.conftest import run

__all__ = ["bench", "own_folder", "run", "shared_folder", "valid"]
