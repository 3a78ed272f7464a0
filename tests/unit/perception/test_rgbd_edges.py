"""RGB-D frames as cameras and hands make them: smeared, from far above, turned by EXIF data, bent by a lens."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from PIL import Image

from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.levels import find_ground
from roomkin.stages.perception import from_rgbd
from roomkin.stages.perception.read.frame import Frame, Labelled
from roomkin.stages.perception.read.mask_pieces import remove_edges
from roomkin.stages.perception.write import write_frame
from tests.refusals import refused
from tests.unit.perception.test_rgbd import BOX, CAN, TABLE, boxes_of
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WALL, WIDTH, trace, write_room


def test_a_wall_is_not_level() -> None:
    """Looking 35 degrees down its normal is 55 degrees from image-up, and it fills more of the picture."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(INTRINSICS).T
    up = np.array([0, -np.cos(np.deg2rad(35)), -np.sin(np.deg2rad(35))])
    out = np.array([0, -up[2], up[1]])  # of the wall, towards the camera
    table, wall = -0.6 / np.minimum(rays @ up, -1e-6), -0.75 / np.minimum(rays @ out, -1e-6)
    points = rays * np.minimum(table, wall)[..., None]
    assert (wall < table).mean() > 0.5
    found = find_ground(points, np.ones((HEIGHT, WIDTH), bool), 75.0)
    assert found is not None and found.normal @ up > 0.999 and found.offset == pytest.approx(-0.6, abs=0.01)


def test_extraction_is_told_that_cameras_in_hands_look_down_steeply(tmp_path: Path) -> None:
    values = np.zeros((HEIGHT, WIDTH), np.uint16)
    values[150:200, 200:260] = 1
    rgb, depth = np.zeros((HEIGHT, WIDTH, 3), np.uint8), np.ones((HEIGHT, WIDTH), np.float32)
    write_frame(tmp_path / "top", Frame(rgb, depth, INTRINSICS, Labelled(values, {1: "book"})))
    told = yaml.safe_load((tmp_path / "top" / "config.yaml").read_text())["extraction"]
    assert told == {"crop": 1.0, "trim": 0.005, "max_tilt": 75.0}


def frame_of(folder: Path, depth: np.ndarray, masks: np.ndarray, names: dict[int, str], orientation: int = 1,
             **lens: object) -> Path:  # fmt: skip
    """The input folder of a frame with masks."""
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(np.dstack([20 * masks] * 3).astype(np.uint8)).save(folder / "rgb.png", exif=exif.tobytes())
    cv2.imwrite(str(folder / "masks.png"), masks)
    np.savez(folder / "depth.npz", depth=depth)
    (folder / "K.json").write_text(json.dumps({"K": INTRINSICS.tolist(), **lens}))
    (folder / "names.json").write_text(json.dumps({str(value): name for value, name in names.items()}))
    from_rgbd.run(
        out=folder / "out",
        rgb=folder / "rgb.png",
        depth=folder / "depth.npz",
        camera=(str(folder / "K.json"),),
        masks=folder / "masks.png",
        labels=folder / "names.json",
    )
    return folder / "out"


def test_what_stands_on_something_unnamed_ends_there(tmp_path: Path) -> None:
    """On a table that is not named a box stays 20 cm high; what is hidden by the table reaches down to the floor."""
    behind = UprightBox([3.7, -0.5, 0.6], [0.3, 0.4, 1.2], 0.0)
    depth, masks = trace([TABLE, BOX, behind], wall=False)
    found = boxes_of(frame_of(tmp_path, depth, masks, {FLOOR: "floor", OBJECT + 1: "box", OBJECT + 2: "cabinet"}))
    assert found["up"] == pytest.approx(1.6, abs=0.02)
    assert found["box_1"].size[2] == pytest.approx(0.2, abs=0.02)
    assert found["box_1"].center[2] == pytest.approx(TABLE.top + 0.1, abs=0.02)
    assert found["cabinet_1"].size[2] == pytest.approx(1.2, abs=0.03)


def test_masks_may_be_some_pixels_off_and_edges_smeared(tmp_path: Path) -> None:
    depth, masks = trace([TABLE, BOX, CAN], wall=False)
    smeared = 0.4 * cv2.blur(depth, (5, 5))  # of things 8 and 6 cm wide, a metre away
    smeared[depth == 0] = 0
    wide = np.zeros_like(masks)
    for value in (OBJECT + 1, OBJECT + 2):
        wide[cv2.dilate((masks == value).astype(np.uint8), np.ones((7, 7))) > 0] = value
    found = boxes_of(frame_of(tmp_path, smeared, wide, {OBJECT + 1: "box", OBJECT + 2: "can"}))
    for name, true in (("box_1", BOX), ("can_1", CAN)):
        assert sorted(found[name].size) == pytest.approx(sorted(0.4 * np.array(true.size)), abs=0.045), name


def test_a_thin_handle_is_kept_and_what_is_behind_a_wide_mask_is_not() -> None:
    """A kettle at 1 m, its handle 10 cm behind, a wall at 1.4 m, all mixed at their edges; the mask reaches over it."""
    thing = np.full((100, 120), 1.4, np.float32)
    thing[20:90, 20:70], thing[30:70, 80:87] = 1.0, 1.1
    rng = np.random.default_rng(0)
    mixed = cv2.dilate(thing, np.ones((5, 5))), cv2.erode(thing, np.ones((5, 5)))
    at_edge = (mixed[0] - mixed[1] > 0.05) & (rng.random(thing.shape) < 0.6)
    depth = np.where(at_edge, mixed[1] + rng.random(thing.shape) * (mixed[0] - mixed[1]), thing).astype(np.float32)
    masks = np.zeros(depth.shape, np.uint16)
    masks[10:92, 18:72], masks[28:72, 78:89] = 1, 1  # 10 rows too high: 500 pixels of wall
    clean = np.where(masks > 0, remove_edges(depth, masks), 0)
    handle = clean[30:70, 80:87]
    assert (np.abs(handle - 1.1) < 0.03).sum() > 0.5 * handle.size
    assert (clean > 1.15).sum() < 10


@pytest.mark.parametrize("orientation", [2, 3, 6])
def test_a_picture_that_its_exif_data_turn_is_refused(tmp_path: Path, orientation: int) -> None:
    with refused("E-PICTURE-TURNED", f"orientation {orientation}", "its depth"):
        frame_of(tmp_path, *trace([BOX]), {OBJECT: "box"}, orientation)
    assert not (tmp_path / "out").exists()


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


def test_what_is_lost_when_the_lens_is_taken_out_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    depth, masks = trace([TABLE])
    masks[:3, :3] = 40
    names = {FLOOR: "floor", OBJECT: "box", 40: "lamp", WALL: "ceiling"}
    frame_of(tmp_path, depth, masks, names, D=[-0.3, 0.1, 0, 0, 0], width=WIDTH, height=HEIGHT)
    told = capsys.readouterr().out
    assert "made straight and fitted, 3 of 4 are left: 'lamp' has no pixels" in told
    assert "left out: 'ceiling' is nothing to place" in told
