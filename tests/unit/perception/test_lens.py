"""Pictures by lenses that bend lines: straight again, with the focal length that belongs to it."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.plugins.annotator import annotate
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception.read.lens import Lens, read_lens, straighten_picture
from roomkin.stages.perception.read.photo import read_photo
from tests.refusals import refused
from tests.unit.perception.test_rgbd_edges import frame_of
from tests.unit.synthetic_room import FLOOR, INTRINSICS, OBJECT, trace
from tests.unit.synthetic_room import HEIGHT as ROOM_HEIGHT
from tests.unit.synthetic_room import WIDTH as ROOM_WIDTH

WIDTH, HEIGHT, FOCAL = 640, 480, 420.0
K = [[FOCAL, 0, 322.0], [0, FOCAL, 236.0], [0, 0, 1]]
BOX = UprightBox([2.2, -0.9, 0.4], [0.6, 0.5, 0.8], 0.3)  # near the border, where a lens bends most
BENT = [-0.28, 0.07, 0.001, -0.0005, 0.0]


def calibration(path: Path, **data: Any) -> Path:
    path.write_text(json.dumps({"width": WIDTH, "height": HEIGHT, "camera_matrix": K, **data}))
    return path


def picture(points: NDArray[np.float64], size: int = 1) -> NDArray[np.uint8]:
    """A line of points of space as the lens draws it, white on dark."""
    pixels = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.array(K), np.array(BENT))[0][:, 0]
    drawn = np.full((HEIGHT * size, WIDTH * size, 3), 20, np.uint8)
    cv2.polylines(
        drawn, [np.rint(pixels * size * 16).astype(np.int32)], False, (255, 255, 255), 2 * size, cv2.LINE_AA, 4
    )
    return drawn


def bend(drawn: NDArray[np.uint8]) -> float:
    """How far the line is from straight at most, in pixels."""
    rows, columns = np.nonzero(drawn[..., 0] > 120)
    fit = np.polynomial.Polynomial.fit(columns, rows, 1)
    return float(np.abs(fit(columns) - rows).max())


LINE = np.column_stack([np.linspace(-2, 2, 200), np.full(200, -1.0), np.full(200, 3.0)])


def test_lines_are_straight_again(tmp_path: Path) -> None:
    drawn = picture(LINE)
    lens = read_lens(calibration(tmp_path / "lens.json", distortion_coefficients={"data": BENT}), WIDTH, HEIGHT)
    straight, focal = straighten_picture(drawn, lens, "lens")
    assert bend(drawn) > 5 and bend(straight) < 2.5 and straight.shape == drawn.shape
    rows = np.nonzero(straight[..., 0] > 120)[0]
    assert (HEIGHT - 1) / 2 - rows.mean() == pytest.approx(focal / 3, abs=1.5)  # one metre up at three metres
    assert (
        straighten_picture(np.full((HEIGHT, WIDTH, 3), 200, np.uint8), lens, "lens")[0] == 200
    ).all()  # no black borders


def test_a_photograph_is_straightened_before_everything(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "wide.png"), picture(LINE, 3))  # 1920 pixels: it is made smaller as well
    lens = tmp_path / "lens.json"  # of the file's size, which it does not say
    lens.write_text(json.dumps({"K": [3 * FOCAL, 0, 967, 0, 3 * FOCAL, 709, 0, 0, 1], "D": BENT}))
    photo = read_photo(tmp_path / "wide.png", lens)
    assert photo.rgb.shape == (1200, 1600, 3) and photo.shrunk > 1 and bend(photo.rgb) < 5
    assert photo.focal is not None and photo.focal == pytest.approx(FOCAL * 2.5, rel=0.15)
    assert bend(read_photo(tmp_path / "wide.png").rgb) > 12
    lens.write_text(json.dumps({"K": [3 * FOCAL, 0, 967, 0, 3 * FOCAL, 709, 0, 0, 1]}))
    with refused("E-LENS-MISSING"):
        read_photo(tmp_path / "wide.png", lens)
    with refused("E-OPTION-CONFLICT"):
        annotate.run(tmp_path / "wide.png", lens=lens, depth=tmp_path / "depth.npz", browser=False)


def bent_frame(kind: str) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    """Depth and masks of a box on a floor as the lens shows them, without the mixing of pixels."""
    depth, masks = trace([BOX], wall=False)
    u, v = np.meshgrid(np.arange(ROOM_WIDTH, dtype=float), np.arange(ROOM_HEIGHT, dtype=float))
    bent = (np.stack([u, v], axis=-1).reshape(-1, 2) - INTRINSICS[:2, 2]) / np.diag(INTRINSICS)[:2]
    none, one, coefficients = np.zeros(3), np.eye(3), np.array(BENT)
    if kind == "inverse":  # the polynomial goes from what is seen to the ray
        rays = cv2.projectPoints(np.column_stack([bent, np.ones(len(bent))]), none, none, one, coefficients)[0]
    else:
        rays = cv2.undistortPoints(bent[:, None], one, coefficients)
    pixels = (rays[:, 0] * np.diag(INTRINSICS)[:2] + INTRINSICS[:2, 2]).astype(np.float32)
    maps = pixels[:, 0].reshape(u.shape), pixels[:, 1].reshape(u.shape)
    return cv2.remap(depth, *maps, cv2.INTER_NEAREST), cv2.remap(masks, *maps, cv2.INTER_NEAREST)


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("", {"D": BENT, "distortion_model": "plumb_bob"}),
        ("inverse", {"coeffs": BENT, "model": "distortion.inverse_brown_conrady"}),
        ("", {}),
        ("", {"D": [], "distortion_model": ""}),
        ("", {"coeffs": [0.0] * 5, "model": "distortion.modified_brown_conrady"}),
    ],
)
def test_rgbd_frames_are_straightened(tmp_path: Path, kind: str, said: dict[str, Any]) -> None:
    """Color, depth and masks alike: what is written is what a pinhole camera with the written K sees of the room."""
    depth, masks = bent_frame(kind)
    written = read_scene_input(frame_of(tmp_path, depth, masks, {FLOOR: "floor", OBJECT: "box"}, **said))
    u, v = np.meshgrid(np.arange(ROOM_WIDTH), np.arange(ROOM_HEIGHT))
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(np.array(written.camera.intrinsics)).T
    x, y, _ = np.moveaxis(np.rint(rays @ INTRINSICS.T).astype(int), -1, 0)
    true_depth, true_masks = trace([BOX], wall=False)
    inside = (x >= 0) & (x < ROOM_WIDTH) & (y >= 0) & (y < ROOM_HEIGHT)
    x, y = x.clip(0, ROOM_WIDTH - 1), y.clip(0, ROOM_HEIGHT - 1)
    on_box = inside & ((written.masks == OBJECT) | (true_masks[y, x] == OBJECT))
    agree = (written.masks == true_masks[y, x])[on_box].mean()
    both = inside & (written.masks == OBJECT) & (true_masks[y, x] == OBJECT)
    off = float(np.quantile(np.abs(written.depth - true_depth[y, x])[both], 0.95))
    color = cv2.imread(str(tmp_path / "out" / "rgb.png"))[..., 0]
    assert (color == written.masks * 20).mean() > 0.97
    if said.get("D") or kind:
        assert inside.mean() > 0.8 and agree > 0.95 and off < 0.02
    else:
        known = written.depth > 0
        assert np.abs(written.depth - depth)[known].max() < 0.001 and known.sum() > 0.9 * (depth > 0).sum()
        assert agree < 0.9


@pytest.mark.parametrize("first", [5.0, 50.0, -5.0])
def test_a_lens_that_leaves_a_smear_is_refused(first: float) -> None:
    picture = np.zeros((ROOM_HEIGHT, ROOM_WIDTH, 3), np.uint8)
    straighten_picture(picture, Lens(INTRINSICS, np.array([first / 20, 0, 0, 0, 0])), "camera.json")
    with refused("E-LENS-WIDE", "camera.json", "bends the picture"):
        straighten_picture(picture, Lens(INTRINSICS, np.array([first, 0, 0, 0, 0])), "camera.json")
