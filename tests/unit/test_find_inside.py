"""Files are found whatever the form of accents in their names."""

import unicodedata
from pathlib import Path

import pytest

from stages.articulated.inside import find_inside


@pytest.mark.parametrize("form", ["NFC", "NFD"])
def test_names_are_alike_in_every_form_of_unicode(tmp_path: Path, form: str) -> None:
    file = tmp_path / unicodedata.normalize(form, "Tür_body.obj")
    file.touch()
    for named in ("NFC", "NFD"):
        found = find_inside(unicodedata.normalize(named, "tür_body.obj"), tmp_path, tmp_path)
        assert found is not None and found.samefile(file)
