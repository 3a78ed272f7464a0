"""Pictures as a viewer shows them: in the colors of their profile, one of a file."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageCms

from roomkin.stages.contracts.images import read_masks, read_rgb
from tests.refusals import refused

RED = np.tile(np.uint8([200, 40, 40]), (32, 32, 1))


def profile(name: str) -> bytes:
    """An sRGB profile under a name of four letters, red and blue exchanged unless it is sRGB."""
    found = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    if name != "sRGB":
        found = found.replace(b"rXYZ", b"temp").replace(b"bXYZ", b"rXYZ").replace(b"temp", b"bXYZ")
    return found.replace("sRGB".encode("utf-16-be"), name.encode("utf-16-be"))


@pytest.mark.parametrize("mode", ["RGB", "RGBA"])
def test_colors_are_those_of_the_profile(tmp_path: Path, mode: str) -> None:
    Image.fromarray(RED).convert(mode).save(tmp_path / "rgb.png", icc_profile=profile("test"))
    assert np.abs(read_rgb(tmp_path / "rgb.png").astype(int) - RED[..., ::-1]).max() <= 3


@pytest.mark.parametrize(
    "given",
    [profile("sRGB"), profile("test").replace("test".encode("utf-16-be"), "sRGB".encode("utf-16-be")), b"no profile"],
)
def test_a_profile_that_changes_nothing_or_is_none_leaves_the_bytes(tmp_path: Path, given: bytes) -> None:
    Image.fromarray(RED).save(tmp_path / "rgb.png", icc_profile=given)
    np.testing.assert_array_equal(read_rgb(tmp_path / "rgb.png"), RED)


@pytest.mark.parametrize("form", ["WEBP", "PNG", "TIFF", "GIF"])
def test_of_several_pictures_in_a_file_none_is_guessed(tmp_path: Path, form: str) -> None:
    first, second = Image.fromarray(RED), Image.fromarray(RED[..., ::-1].copy())
    first.save(tmp_path / "rgb.png", form, save_all=True, append_images=[second])
    for read in (read_rgb, read_masks):
        with refused("E-IMAGE-MANY", "holds 2 pictures"):
            read(tmp_path / "rgb.png")


def test_the_second_picture_of_a_phone_is_no_other(tmp_path: Path) -> None:
    first, second = Image.fromarray(RED), Image.fromarray(RED[:16, :16].copy())
    first.save(tmp_path / "rgb.jpg", "MPO", save_all=True, append_images=[second])
    assert np.abs(read_rgb(tmp_path / "rgb.jpg").astype(int) - RED).max() < 8
