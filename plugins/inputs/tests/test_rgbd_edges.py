"""RGB-D frames as cameras and hands make them: masks some pixels off, smeared edges, from far above, before a wall."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from plugins.inputs import from_rgbd
from plugins.inputs.rgbd.edges import remove_edges
from plugins.inputs.rgbd.frame import Frame, Labelled
from plugins.inputs.rgbd.write import write_frame
from plugins.inputs.tests.test_rgbd import BOX, CAN, TABLE, boxes_of
from stages.geometry.boxes import UprightBox
from stages.geometry.levels import find_ground
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WIDTH, trace


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


def frame_of(folder: Path, depth: np.ndarray, masks: np.ndarray, names: dict[int, str]) -> Path:
    """The input folder of a frame with masks."""
    cv2.imwrite(str(folder / "rgb.png"), np.dstack([20 * masks] * 3).astype(np.uint8))
    cv2.imwrite(str(folder / "masks.png"), masks)
    np.savez(folder / "depth.npz", depth=depth)
    (folder / "K.txt").write_text(" ".join(map(str, INTRINSICS.ravel())))
    (folder / "names.json").write_text(json.dumps({str(value): name for value, name in names.items()}))
    from_rgbd.run(
        out=folder / "out",
        rgb=folder / "rgb.png",
        depth=folder / "depth.npz",
        camera=(str(folder / "K.txt"),),
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
