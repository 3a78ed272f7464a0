"""A picture that its EXIF data turn: depth, masks and intrinsics are turned by a quarter with it, or it is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from plugins.inputs import from_rgbd
from plugins.inputs.rgbd.upright import turn_array
from stages.contracts import Camera, read_json
from stages.contracts.scene_input import read_scene_input
from stages.geometry.boxes import UprightBox
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WALL, WIDTH, trace, write_room

BOX = UprightBox([2.6, 0.5, 0.4], [0.6, 0.8, 0.8], 0.2)
K = {"fx": 400.0, "fy": 410.0, "cx": 236.0, "cy": 184.0}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """What the sensor wrote: depth, masks, names, intrinsics with their size."""
    depth, masks = trace([BOX])
    np.save(tmp_path / "depth.npy", depth)
    Image.fromarray(masks).save(tmp_path / "masks.png")
    (tmp_path / "names.json").write_text(json.dumps({str(FLOOR): "floor", str(WALL): "wall", str(OBJECT): "box"}))
    (tmp_path / "K.json").write_text(json.dumps({**K, "width": WIDTH, "height": HEIGHT}))
    return tmp_path


def colour(folder: Path, orientation: int, square: bool = False) -> Path:
    """The sensor's picture: its masks in grey."""
    exif = Image.Exif()
    exif[0x0112] = orientation
    picture = np.dstack([trace([BOX])[1] * 20] * 3).astype(np.uint8)
    Image.fromarray(picture[:, :HEIGHT] if square else picture).save(folder / "rgb.png", exif=exif.tobytes())
    return folder / "rgb.png"


def run(folder: Path, orientation: int, **other: Any) -> Path:
    given = {"depth": folder / "depth.npy", "camera": (str(folder / "K.json"),), "masks": folder / "masks.png"}
    from_rgbd.run(out=folder / "out", rgb=colour(folder, orientation), labels=folder / "names.json", **given | other)
    return folder / "out"


@pytest.mark.parametrize("orientation", [5, 6, 7, 8])
def test_a_quarter_turn_turns_all_files(folder: Path, orientation: int, capsys: pytest.CaptureFixture[str]) -> None:
    out = run(folder, orientation)
    given = read_scene_input(out)
    assert given.rgb.shape == (WIDTH, HEIGHT, 3)
    assert np.array_equal(given.rgb[..., 0], given.masks * 20), "masks lie on the picture"
    depth = turn_array(trace([BOX])[0], orientation)
    assert np.abs(given.depth - depth)[given.depth > 0].max() < 1e-5
    (fx, _, cx), (_, fy, cy), _ = read_json(Camera, out / "camera.json").intrinsics
    assert (fx, fy) == (410, 400)
    assert cx == (HEIGHT - 1 - 184 if orientation in (6, 7) else 184)
    assert cy == (WIDTH - 1 - 236 if orientation in (7, 8) else 236)
    said = capsys.readouterr().out
    assert all(f"{folder / name}: turned with its picture" in said for name in ("depth.npy", "masks.png"))
    assert "intrinsics are of the 480x360 pixels that the sensor wrote" in said


def test_what_is_upright_already_stays(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    depth, masks = (np.rot90(array, -1) for array in trace([BOX]))
    np.save(folder / "depth.npy", depth)
    Image.fromarray(np.ascontiguousarray(masks)).save(folder / "masks.png")
    upright = {"fx": 410.0, "fy": 400.0, "cx": 175.0, "cy": 236.0}
    (folder / "K.json").write_text(json.dumps({**upright, "width": HEIGHT, "height": WIDTH}))
    out = run(folder, 6)
    assert np.array_equal(read_scene_input(out).rgb[..., 0], read_scene_input(out).masks * 20)
    assert read_json(Camera, out / "camera.json").intrinsics[0][2] == 175
    assert "turned with its picture" not in capsys.readouterr().out


def test_intrinsics_without_a_size_are_those_of_the_picture_in_whose_middle_they_are(folder: Path) -> None:
    (folder / "K.json").write_text(json.dumps(K))
    assert read_json(Camera, run(folder, 6) / "camera.json").intrinsics[0] == [410, 0, HEIGHT - 1 - 184]
    out = run(folder, 6, camera=("410", "400", "175", "236"))
    assert read_json(Camera, out / "camera.json").intrinsics[0] == [410, 0, 175]


@pytest.mark.parametrize("orientation", [2, 3, 4])
def test_half_a_turn_and_mirrors_are_refused(folder: Path, orientation: int) -> None:
    with refused("E-PICTURE-TURNED", f"orientation {orientation}", "its depth"):
        run(folder, orientation)
    assert not (folder / "out").exists()


def test_a_quarter_turn_of_a_square_and_of_a_lens_are_refused(folder: Path) -> None:
    with refused("E-PICTURE-TURNED", "its depth"):
        from_rgbd.run(
            out=folder / "out", rgb=colour(folder, 6, square=True), depth=folder / "depth.npy", camera=("60",)
        )
    (folder / "K.json").write_text(json.dumps({**K, "width": WIDTH, "height": HEIGHT, "k1": -0.1}))
    with refused("E-PICTURE-TURNED", "its lens"):
        run(folder, 6)


def test_a_recording_is_turned_alike(folder: Path) -> None:
    recording = folder / "recording"
    for name in ("color", "depth"):
        (recording / name).mkdir(parents=True)
    colour(folder, 8).rename(recording / "color/0.png")
    (folder / "depth.npy").rename(recording / "depth/0.npy")
    (folder / "K.json").rename(recording / "intrinsics.json")
    from_rgbd.run(out=folder / "out", recording=recording, masks=folder / "masks.png", labels=folder / "names.json")
    given = read_scene_input(folder / "out")
    assert np.array_equal(given.rgb[..., 0], given.masks * 20)


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
