"""Files that do not lie on each other: a picture that its EXIF data turn, masks that lose things."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from plugins.inputs import from_rgbd
from stages.contracts.scene_input import read_scene_input
from stages.geometry.boxes import UprightBox
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WALL, WIDTH, trace, write_room

BOX = UprightBox([2.6, 0.5, 0.4], [0.6, 0.8, 0.8], 0.2)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """What the sensor wrote: depth, masks, names, intrinsics with their size."""
    depth, masks = trace([BOX])
    np.save(tmp_path / "depth.npy", depth)
    Image.fromarray(masks).save(tmp_path / "masks.png")
    (tmp_path / "names.json").write_text(json.dumps({str(FLOOR): "floor", str(WALL): "wall", str(OBJECT): "box"}))
    (tmp_path / "K.json").write_text(json.dumps(INTRINSICS.tolist()))
    return tmp_path


def colour(folder: Path, orientation: int) -> Path:
    """The sensor's picture: its masks in grey."""
    exif = Image.Exif()
    exif[0x0112] = orientation
    picture = np.dstack([trace([BOX])[1] * 20] * 3).astype(np.uint8)
    Image.fromarray(picture).save(folder / "rgb.png", exif=exif.tobytes())
    return folder / "rgb.png"


def run(folder: Path, orientation: int) -> None:
    from_rgbd.run(
        out=folder / "out",
        rgb=colour(folder, orientation),
        depth=folder / "depth.npy",
        camera=(str(folder / "K.json"),),
        masks=folder / "masks.png",
        labels=folder / "names.json",
    )


@pytest.mark.parametrize("orientation", [2, 3, 6])
def test_a_picture_that_its_exif_data_turn_is_refused(folder: Path, orientation: int) -> None:
    with refused("E-PICTURE-TURNED", f"orientation {orientation}", "its depth"):
        run(folder, orientation)
    assert not (folder / "out").exists()


def test_an_input_folder_says_that_its_files_are_taken_to_be_upright(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_room(tmp_path, [BOX], ["box"])
    exif = Image.Exif()
    exif[0x0112] = 3
    with Image.open(tmp_path / "rgb.png") as picture:
        picture.save(tmp_path / "rgb.png", exif=exif.tobytes())
    read_scene_input(tmp_path)
    assert "is turned by its EXIF data (3); depth and masks are taken to be upright" in capsys.readouterr().out


def test_what_is_lost_when_the_lens_is_taken_out_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    masks = trace([BOX])[1]
    masks[:3, :3] = 40
    Image.fromarray(masks).save(folder / "masks.png")
    names = {str(FLOOR): "floor", str(OBJECT): "box", "40": "lamp", str(WALL): "ceiling"}
    (folder / "names.json").write_text(json.dumps(names))
    said = {"K": INTRINSICS.tolist(), "D": [-0.3, 0.1, 0, 0, 0], "width": WIDTH, "height": HEIGHT}
    (folder / "K.json").write_text(json.dumps(said))
    run(folder, 1)
    told = capsys.readouterr().out
    assert "made straight and fitted, 3 of 4 are left: 'lamp' has no pixels" in told
    assert "left out: 'ceiling' is nothing to place" in told
