"""Pictures of all directions are refused; others that are twice as wide as high are not."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from roomkin.stages.perception.read.photo import read_photo, shows_all_around
from tests.refusals import refused


def look_around(wide: int = 1024, high: int = 512) -> NDArray[np.uint8]:
    """A room of boxes in all directions: a corner every quarter, ceiling and floor."""
    u, v = np.meshgrid((np.arange(wide) + 0.5) / wide * 2 * np.pi, (np.arange(high) + 0.5) / high * np.pi)
    ray = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)
    side = np.abs(ray).argmax(axis=-1)
    hit = ray / np.abs(ray).max(axis=-1, keepdims=True)
    colors = np.array([[150, 90, 60], [70, 120, 150], [200, 200, 190]])[side]
    stripes = 40 * ((hit @ [3.0, 2.0, 1.0] * 2).astype(int) % 2) * (side != 2)
    return np.asarray((colors + stripes[..., None]).clip(0, 255), dtype=np.uint8)


@pytest.mark.parametrize("turned", [0, 300])
@pytest.mark.parametrize("noise", [0, 4])
def test_a_picture_of_all_directions_is_refused(tmp_path: Path, turned: int, noise: float) -> None:
    picture = np.roll(look_around(), turned, axis=1) + np.random.default_rng(0).normal(0, noise, (512, 1024, 3))
    Image.fromarray(picture.clip(0, 255).astype(np.uint8)).save(tmp_path / "p.jpg", quality=90)
    with refused("E-PICTURE-PANORAMA", "is a panorama (1024x512)", "cut out a part"):
        read_photo(tmp_path / "p.jpg")


def framed(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.pad(picture, ((12, 12), (24, 24), (0, 0)), constant_values=255)


@pytest.mark.parametrize(
    "picture",
    [
        look_around()[128:384, 200:712],  # a part of it
        look_around()[:, :900],
        np.hstack([look_around()[100:356], look_around()[100:356, ::-1]])[:, 768:1280],  # alike at both sides
        framed(look_around()[128:384, 200:712]),
        np.full((100, 200, 3), 90, np.uint8),
        np.vstack([np.full((100, 400, 3), 210), look_around()[200:250, 100:500], np.full((50, 400, 3), 80)]),
    ],
)
def test_pictures_that_are_twice_as_wide_as_high(picture: NDArray[np.uint8]) -> None:
    assert not shows_all_around(picture.astype(np.uint8))
