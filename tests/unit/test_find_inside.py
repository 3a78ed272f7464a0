"""Files are found whatever the form of accents in their names."""

import unicodedata
from pathlib import Path

import pytest

from roomkin.stages.articulated.mesh_resolver import find_inside, is_link_out


@pytest.mark.parametrize("form", ["NFC", "NFD"])
def test_names_are_alike_in_every_form_of_unicode(tmp_path: Path, form: str) -> None:
    file = tmp_path / unicodedata.normalize(form, "Tür_body.obj")
    file.touch()
    for named in ("NFC", "NFD"):
        found = find_inside(unicodedata.normalize(named, "tür_body.obj"), tmp_path, tmp_path)
        assert found is not None and found.samefile(file)


def test_a_link_out_of_the_folder_is_told_from_a_way_out_and_from_a_link_inside(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    (folder / "parts").mkdir(parents=True)
    for file in (tmp_path / "a.obj", folder / "parts/a.obj"):
        file.touch()
    (folder / "out.obj").symlink_to(tmp_path / "a.obj")
    (folder / "in.obj").symlink_to("parts/a.obj")
    (folder / "gone.obj").symlink_to(tmp_path / "gone.obj")
    assert [name for name in ("out.obj", "in.obj", "gone.obj", "../a.obj") if is_link_out(name, folder, folder)] == [
        "out.obj"
    ]
