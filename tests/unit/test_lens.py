"""Pictures by lenses that bend lines: straight again, with the focal length that belongs to it."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from stages.contracts import InputError
from stages.extraction import annotate
from stages.extraction.by_hand.photo import read_photo
from stages.scenes.rgbd.lens import read_lens, straightened

WIDTH, HEIGHT, FOCAL = 640, 480, 420.0
K = [[FOCAL, 0, 322.0], [0, FOCAL, 236.0], [0, 0, 1]]
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
    straight, focal = straightened(drawn, lens, "lens")
    assert bend(drawn) > 5 and bend(straight) < 2.5 and straight.shape == drawn.shape
    rows = np.nonzero(straight[..., 0] > 120)[0]
    assert (HEIGHT - 1) / 2 - rows.mean() == pytest.approx(focal / 3, abs=1.5)  # one metre up at three metres
    assert (straightened(np.full((HEIGHT, WIDTH, 3), 200, np.uint8), lens, "lens")[0] == 200).all()  # no black borders


@pytest.mark.parametrize(
    "data",
    [
        {"distortion_coefficients": {"rows": 1, "cols": 5, "data": BENT}, "distortion_model": "plumb_bob"},
        {"D": BENT},
        {"dist_coeffs": [BENT]},
        {"k1": BENT[0], "k2": BENT[1], "p1": BENT[2], "p2": BENT[3]},
        {"distortion": {"k1": BENT[0], "k2": BENT[1], "p1": BENT[2], "p2": BENT[3], "k3": 0}},
        {"D": BENT[:4]},
    ],
)
def test_calibrations_of_any_usual_layout(tmp_path: Path, data: dict[str, Any]) -> None:
    lens = read_lens(calibration(tmp_path / "lens.json", **data), WIDTH, HEIGHT)
    np.testing.assert_allclose(lens.distortion[:5], BENT)
    np.testing.assert_allclose(lens.intrinsics, K)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({}, "holds no distortion"),
        ({"D": BENT, "distortion_model": "equidistant"}, "'equidistant'"),
        ({"D": ["much"]}, "holds no distortion"),
        ({"D": [1, 2, 3]}, "holds no distortion"),
        ({"D": [float("nan")] * 5}, "holds no distortion"),
    ],
)
def test_what_is_no_calibration_is_one_line(tmp_path: Path, data: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_lens(calibration(tmp_path / "lens.json", **data), WIDTH, HEIGHT)


def test_a_photograph_is_straightened_before_everything(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "wide.png"), picture(LINE, 3))  # 1920 pixels: it is made smaller as well
    lens = tmp_path / "lens.json"  # of the file's size, which it does not say
    lens.write_text(json.dumps({"K": [3 * FOCAL, 0, 967, 0, 3 * FOCAL, 709, 0, 0, 1], "D": BENT}))
    photo = read_photo(tmp_path / "wide.png", lens)
    assert photo.rgb.shape == (1200, 1600, 3) and photo.shrunk > 1 and bend(photo.rgb) < 5
    assert photo.focal is not None and photo.focal == pytest.approx(FOCAL * 2.5, rel=0.15)
    assert bend(read_photo(tmp_path / "wide.png").rgb) > 12
    with pytest.raises(InputError, match="bends the picture, not the depth"):
        annotate.run(tmp_path / "wide.png", lens=lens, depth=tmp_path / "depth.npz", browser=False)
