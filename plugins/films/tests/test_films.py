"""Films that people write: the ending says the format."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.films.kinds import Film
from roomkin.plugins.films.writing import LAST, write_film
from tests.refusals import refused

PICTURES = [np.full((31, 40, 3), level, np.uint8) for level in (0, 120, 240)]


@pytest.mark.parametrize("form", ["webp", "gif"])
def test_pictures_that_move_run_for_ever(tmp_path: Path, form: str) -> None:
    write_film(tmp_path / f"film.{form}", PICTURES, 20)
    with Image.open(tmp_path / f"film.{form}") as film:
        assert (film.format, film.n_frames, film.size) == (form.upper(), 3, (40, 31))  # type: ignore[attr-defined]


def test_mp4_is_mp4(tmp_path: Path) -> None:
    write_film(tmp_path / "film.mp4", PICTURES, 20)
    assert (tmp_path / "film.mp4").read_bytes()[4:8] == b"ftyp"
    film = cv2.VideoCapture(str(tmp_path / "film.mp4"))
    assert film.get(cv2.CAP_PROP_FPS) == 20 and film.get(cv2.CAP_PROP_FRAME_COUNT) == 3 + LAST * 20 // 1000
    assert (film.get(cv2.CAP_PROP_FRAME_WIDTH), film.get(cv2.CAP_PROP_FRAME_HEIGHT)) == (40, 30)


def test_other_endings_and_no_pictures_are_refused(tmp_path: Path) -> None:
    with refused("E-FILM", "is in no format"):
        write_film(tmp_path / "film.avi", PICTURES, 20)
    with refused("E-FILM", "gets no pictures"):
        write_film(tmp_path / "film.webp", [], 20)
    assert not [*tmp_path.iterdir()]


def test_a_film_lies_beside_its_list() -> None:
    with pytest.raises(ValueError, match="file"):
        Film(role="twin", asset="a", seed=0, success=True, steps=1, opened=0.0, file="../a.webp")
