"""The published weights, for tests that read them."""

from plugins.eyes.tests.conftest import published

__all__ = ["published"]
