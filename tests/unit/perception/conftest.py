"""The published weights, for tests that read them."""

import pytest

from roomkin.stages.config.weights import FOLDER
from roomkin.stages.perception.fetch import fetch_missing


@pytest.fixture(scope="session")
def published() -> None:
    """The weights are there; without an index and a network that is skipped."""
    missing = fetch_missing(FOLDER)
    if missing:
        pytest.skip(f"weights cannot be fetched: {missing}")
