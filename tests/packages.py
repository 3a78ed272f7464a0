"""Tests that want packages beside the core."""

from pathlib import Path

import pytest

PLUGINS = Path(__file__).resolve().parents[1] / "plugins"


def needs(*names: str) -> pytest.MarkDecorator:
    """Leave a test out where one of these packages is not."""
    missing = [name for name in names if not (PLUGINS / name).is_dir()]
    return pytest.mark.skipif(bool(missing), reason=f"without {', '.join(missing)}")
