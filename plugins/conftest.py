"""Fixtures that tests of packages share with those of the core."""

from tests.unit.conftest import bench, valid
from tests.workflow.conftest import run

__all__ = ["bench", "run", "valid"]
