"""What a library raises reaches people in words: no message names a class of exceptions."""

import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from roomkin.stages.contracts.errors import explain

ROOT = Path(__file__).resolve().parents[2]
NAMED = re.compile(r"__class__\.__name__|type\(\w+\)\.__name__")


def _read_missing(_: Path) -> None:
    {"fx": 1}["fy"]


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (Image.open, "damaged, cut off, or of another format"),
        (zipfile.ZipFile, "damaged, cut off, or of another format"),
        (np.loadtxt, "something in it is of another form"),
        (lambda path: path.read_text(encoding="ascii"), "it is no text in UTF-8"),
        (lambda path: (path / "inside").read_text(), "not a directory"),
        (_read_missing, "something in it is missing, or of another form"),
    ],
)
def test_what_a_library_raises_is_told_in_words(read: object, words: str, tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("four chairs, one t\u00e4ble")
    with pytest.raises(Exception) as raised:
        read(path)  # type: ignore[operator]
    assert explain(raised.value) == words  # type: ignore[arg-type]


def test_no_message_names_a_class() -> None:
    files = [
        path for home in ("stages", "plugins") for path in (ROOT / home).rglob("*.py") if "tests" not in path.parts
    ]
    assert len(files) > 300
    named = [path for path in files if NAMED.search(path.read_text(encoding="utf-8"))]
    assert not named, "explain(error) says it in words"
