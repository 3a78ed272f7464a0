"""Fixtures that tests of packages share with those of the core."""

import pytest

from tests.conftest import own_folder, shared_folder
from tests.unit.conftest import bench, valid
from tests.workflow.conftest import run

if __name__ != "roomkin.plugins.conftest":  # else modules would be there twice, under two names
    raise pytest.UsageError("plugins: its tests are reached by way of roomkin. Fix: pytest roomkin/plugins/...")

__all__ = ["bench", "own_folder", "run", "shared_folder", "valid"]
