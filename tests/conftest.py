"""The order in which two workers go through the tests, a file at a time; each takes one core."""

import os
import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

# Before numpy and torch are loaded: two workers of two threads each, on two cores, wait for each other's threads.
os.environ.setdefault("OMP_NUM_THREADS", "1")

PLUGINS = Path(__file__).resolve().parents[1] / "plugins"
FIRST = ("test_own_commands.py",)  # makes the micro run, which takes longest, while the other worker does the rest
LAST = ("test_kill.py", "test_shipped_swaps.py", "test_run.py", "test_package.py", "test_notebook.py")  # use it


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Leave out tests of packages beside the core that are not here: the core is tested without them, too."""
    if collection_path.suffix != ".py":
        return None
    text = collection_path.read_text(encoding="utf-8")
    named = re.findall(r"^\s*(?:from|import) roomkin\.plugins\.(\w+)", text, re.MULTILINE)
    return True if any(not (PLUGINS / name).is_dir() for name in named) else None


def _place(item: pytest.Item) -> int:
    name = Path(str(item.path)).name
    return -1 if name in FIRST else LAST.index(name) + 1 if name in LAST else 0


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files at both ends; everything else keeps its order."""
    items.sort(key=_place)


@pytest.fixture(scope="session", autouse=True)
def shared_folder(tmp_path_factory: pytest.TempPathFactory) -> None:
    """The working directory of fixtures that tests share: what a run left in the clone is neither read nor changed."""
    os.chdir(tmp_path_factory.mktemp("shared"))


@pytest.fixture(autouse=True)
def own_folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The working directory of a test; not `tmp_path`, which a test may replace as a whole."""
    with TemporaryDirectory() as folder:
        monkeypatch.chdir(folder)
        yield
