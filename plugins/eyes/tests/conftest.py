"""The published weights, for tests that read them."""

import pytest

from plugins.eyes.fetch import fetch_missing
from plugins.eyes.weights import FOLDER


@pytest.fixture(scope="session")
def published() -> None:
    """The weights are there; without an index and a network that is skipped."""
    missing = fetch_missing(FOLDER)
    if missing:
        pytest.skip(f"weights cannot be fetched: {next(iter(missing.values()))}")
