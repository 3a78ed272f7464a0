"""What a clone is: small, and with LF wherever git is told to write CRLF."""

import subprocess
from pathlib import Path

import pytest

from tests.workflow.workspace import ROOT


def git(*words: str, folder: Path = ROOT) -> list[str]:
    """The lines that git prints."""
    done = subprocess.run(["git", *words], cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shallow clone as on Windows."""
    if not (ROOT / ".git").exists():
        pytest.skip("no repository")
    folder = tmp_path_factory.mktemp("clone")
    git("clone", "-q", "--depth", "1", "-c", "core.autocrlf=true", ROOT.as_uri(), str(folder))
    return folder


def test_every_text_has_lf(clone: Path) -> None:
    lines = git("ls-files", "--eol", folder=clone)
    assert len(lines) > 1000 and not [line for line in lines if "w/crlf" in line or "w/mixed" in line]


def test_a_clone_is_small(clone: Path) -> None:
    files = [path for path in clone.rglob("*") if path.is_symlink() or not path.is_dir()]  # no folders
    assert sum(path.lstat().st_size for path in files) < 20e6  # a third of it below .git
