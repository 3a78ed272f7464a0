"""Intrinsics as other tools write them are read, scaled and told, or refused by the name of what is not read."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from roomkin.stages.contracts import Camera
from roomkin.stages.geometry.frames import scale_intrinsics
from roomkin.stages.perception.read.camera_files import contents
from roomkin.stages.perception.read.cameras import intrinsics_of_camera
from roomkin.stages.perception.read.lens import find_distortion, read_lens
from tests.refusals import refused

WIDTH, HEIGHT = 640, 480
K = np.array([[600.0, 0, 320], [0, 610.0, 240], [0, 0, 1]])
FOUR = np.eye(4)
FOUR[:3, :3] = K
P = np.column_stack([K, [-45.0, 0, 0]])  # of the right camera of a pair
FLAT = {"fx": 600, "fy": 610, "cx": 320, "cy": 240}
OPENCV = """%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 600., 0., 320., 0., 610., 240., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
"""
SCANNET = (
    "m_colorWidth = 640\nm_colorHeight = 480\nm_calibrationColorIntrinsic = 600 0 320 0 0 610 240 0 0 0 1 0 0 0 0 1\n"
)


def camera(tmp_path: Path, said: object, picture: str = "") -> NDArray[np.float64]:
    path = tmp_path / "K"
    path.write_text(said if isinstance(said, str) else json.dumps(said))
    return read_lens(path, WIDTH, HEIGHT, picture).intrinsics


def rows(matrix: NDArray[np.float64]) -> str:
    return "\n".join(" ".join(map(str, row)) for row in matrix)


@pytest.mark.parametrize(
    "said",
    [
        rows(FOUR),  # ScanNet
        rows(FOUR.T),
        rows(P),
        " ".join(map(str, P.ravel())),
        "640 480 600 610 320 240",  # ARKitScenes
        "600 610 320 240 640 480",
        json.dumps(FOUR.tolist()),
        {"intrinsic": FOUR.tolist()},
        {"intrinsics": FOUR.T.ravel().tolist()},
        {"K": K.ravel().tolist(), "P": P.ravel().tolist(), "D": [0] * 5, "width": 640, "height": 480},
        {"P": P.ravel().tolist()},
        yaml.safe_dump(
            {"camera_matrix": {"data": K.ravel().tolist()}, "projection_matrix": {"data": (0.9 * P).ravel().tolist()}}
        ),  # ROS
        {"projection_matrix": {"rows": 3, "cols": 4, "data": P.ravel().tolist()}},
        {"camera_info": 1, "camera": {"intrinsics": {**FLAT, "resolution": [640, 480]}}},
        {"color": FLAT, "depth": {"fx": 400, "fy": 400, "cx": 200, "cy": 150}, "width": 848, "height": 480}
        | {"color": {**FLAT, "width": 640, "height": 480}},
        {"cam0": {"camera_model": "pinhole", "intrinsics": [1200, 1220, 640.5, 480.5], "resolution": [1280, 960]}},
        {"cam0": {"intrinsics": [1200, 1220, 640.5, 480.5], "width": 1280, "resolution": [1280, 960]}},
        {"fl_x": 600, "fl_y": 610, "cx": 320.5, "cy": 240.5, "w": 640, "h": 480, "camera_model": "OPENCV"},
        {"cam_K": K.ravel().tolist(), "depth_scale": 0.1},
        {"intrinsic": {"width": 640, "height": 480, "intrinsic_matrix": K.T.ravel().tolist()}, "extrinsic": [1] * 16},
        {**FLAT, "fx": 600, "ppx": 320, "ppy": 240, "width": 640, "height": 480},
        {"img_width": 1280, "img_height": 960, "fx": 1200, "fy": 1220, "x_offset": 640.5, "ppy": 480.5},
        OPENCV,
        SCANNET,
        "fx_color = 600\nfy_color = 610\nmx_color = 320\nmy_color = 240\ncolorWidth = 640\ncolorHeight = 480",
        "Camera.type: PinHole\nCamera.fx: 600\nCamera.fy: 610\nCamera.cx: 320\nCamera.cy: 240\n",
        "# Camera list\n1 PINHOLE 640 480 600 610 320.5 240.5\n",
        "1 OPENCV 1280 960 1200 1220 641 481 0 0 0 0",
    ],
)
def test_files_of_other_tools(tmp_path: Path, said: object) -> None:
    np.testing.assert_allclose(camera(tmp_path, said), K, atol=1e-6)


def test_arrays_with_names(tmp_path: Path) -> None:
    np.save(tmp_path / "K.npy", K)
    np.testing.assert_allclose(read_lens(tmp_path / "K.npy", WIDTH, HEIGHT).intrinsics, K)
    np.savez(tmp_path / "calibration.npz", mtx=K, dist=np.array([[-0.2, 0.05, 0, 0, 0]]))
    np.testing.assert_allclose(read_lens(tmp_path / "calibration.npz", WIDTH, HEIGHT).intrinsics, K)
    assert read_lens(tmp_path / "calibration.npz", WIDTH, HEIGHT).distortion[:2].tolist() == [-0.2, 0.05]


@pytest.mark.parametrize("said", [{"camera_angle_x": 2 * np.arctan(320 / 600)}, {"fl_x": 600.0}])
def test_an_axis_that_nerf_tools_leave_out_is_in_the_middle(tmp_path: Path, said: object) -> None:
    found = camera(tmp_path, said)
    np.testing.assert_allclose(found, [[600, 0, 319.5], [0, 600, 239.5], [0, 0, 1]])


def test_of_many_cameras_the_picture_s_own_is_taken(tmp_path: Path) -> None:
    other = {"cam_K": [500, 0, 320, 0, 500, 240, 0, 0, 1]}
    bop = {"3": {"cam_K": K.ravel().tolist()}, "4": other}
    np.testing.assert_allclose(camera(tmp_path, bop, "000003.png"), K)
    assert camera(tmp_path, bop, "000004.png")[0, 0] == 500
    frames = [
        {"file_path": f"images/{name}.png", "fl_x": fx, "cx": 320.5, "cy": 240.5}
        for name, fx in (("a", 600), ("b", 500))
    ]
    assert camera(tmp_path, {"w": 640, "h": 480, "frames": frames}, "b.png")[0, 0] == 500
    splats = [{"img_name": "a", **FLAT}, {"img_name": "b", **FLAT, "fx": 500, "fy": 500}]
    assert camera(tmp_path, splats, "b.jpg")[0, 0] == 500
    same = {"3": bop["3"], "4": bop["3"]}
    np.testing.assert_allclose(camera(tmp_path, same, "x.png"), K)
    two = "1 PINHOLE 640 480 600 610 320.5 240.5\n2 PINHOLE 640 480 500 500 320.5 240.5"
    for said in (bop, {"frames": frames}, splats, two):
        with refused("E-CAMERA-PICTURE", "2 different cameras"):
            camera(tmp_path, said, "x.png")


@pytest.mark.parametrize(
    ("said", "code", "says"),
    [
        (rows(np.array([[600.0, 5, 320], [0, 610, 240], [0, 0, 1]])), "CAMERA-INTRINSICS", "skew"),
        ({"K": [600, 5, 320, 0, 610, 240, 0, 0, 1]}, "CAMERA-INTRINSICS", "skew"),
        ({**FLAT, "skew": 3.0}, "CAMERA-INTRINSICS", "skew"),
        ({"K": [0] * 9}, "CAMERA-INTRINSICS", ""),
        ("1 2 3", "CAMERA-INTRINSICS", ""),
        ("600 610 320 2400", "CAMERA-INTRINSICS", ""),
        ({"fx": "a", "fy": 1, "cx": 1, "cy": 1}, "CAMERA-INTRINSICS", ""),
        ("", "CAMERA-INTRINSICS", "no intrinsics"),
        ({"K": list(range(1, 17))}, "CAMERA-INTRINSICS", "a matrix that is no"),
        ({"K": [1, 2, 3, 40, 5, 6]}, "CAMERA-INTRINSICS", "six numbers"),
        ({**FLAT, "width": 640, "height": 640}, "CAMERA-SIZE", "other proportions"),
        ({**FLAT, "roi": {"x_offset": 40, "y_offset": 0, "width": 500}}, "CAMERA-SIZE", "part of the picture"),
        ({"fx": 600, "cx": 320, "cy": 240}, "CAMERA-INTRINSICS", ""),
        ({**FLAT, "camera_model": "omni"}, "LENS-MODEL", "omni"),
        ({"w": 640, "h": 480, "fl_x": 600, "camera_model": "EQUIRECTANGULAR"}, "LENS-MODEL", "equirectangular"),
        ("1 FOV 640 480 600 610 320 240 0.9", "LENS-MODEL", "fov"),
        ("1 THIN_PRISM_FISHEYE 640 480 600 610 320 240 0 0 0 0 0 0 0 0", "LENS-MODEL", "thin_prism_fisheye"),
        ("[LEFT_CAM_HD]\nfx=600\nfy=610\ncx=320\ncy=240\n", "FILE-UNREADABLE", ""),
        ("camera: &a\n  camera: *a\n", "FILE-UNREADABLE", ""),
        ("a: [1, 2", "FILE-UNREADABLE", ""),
        ("fx = 600\nfx = 700\nfy = 610\ncx = 320\ncy = 240\n", "CAMERA-INTRINSICS", "no intrinsics"),
    ],
)
def test_what_is_not_read_is_refused(tmp_path: Path, said: object, code: str, says: str) -> None:
    with refused(f"E-{code}", says):
        camera(tmp_path, said)


@pytest.mark.parametrize("shrunk", [0.5, 0.6, 1.4])
def test_intrinsics_of_another_resolution_are_scaled_or_refused(
    tmp_path: Path, shrunk: float, capsys: pytest.CaptureFixture[str]
) -> None:
    other = scale_intrinsics(K, shrunk, shrunk)
    np.testing.assert_allclose(
        camera(tmp_path, {"K": other.tolist(), "width": 640 * shrunk, "height": 480 * shrunk}), K
    )
    assert f"is of {640 * shrunk:g}x{480 * shrunk:g} pixels, scaled to the picture's 640x480" in capsys.readouterr().out
    with refused("E-CAMERA-INTRINSICS"):
        camera(tmp_path, {"K": other.tolist()})
    with pytest.raises(ValueError, match="intrinsics"):
        Camera(width=640, height=480, intrinsics=other.tolist())


def test_an_axis_beside_the_middle_is_believed() -> None:
    for cx, cy in ((320, 300), (250, 240), (400, 200)):
        Camera(width=640, height=480, intrinsics=[[600, 0, cx], [0, 600, cy], [0, 0, 1]])


def lens(tmp_path: Path, said: object) -> list[float] | None:
    path = tmp_path / "K"
    path.write_text(said if isinstance(said, str) else json.dumps(said))
    found = find_distortion(path, contents(path), K, WIDTH, HEIGHT)
    return None if found is None else found.tolist()


@pytest.mark.parametrize(
    ("said", "found"),
    [
        ({"D": [0.1, -0.2, 0.01, 0.02]}, [0.1, -0.2, 0.01, 0.02, 0]),
        ({"D": [0.1, -0.2, 0.01, 0.02, 0.3, 0, 0, 0]}, [0.1, -0.2, 0.01, 0.02, 0.3]),
        ({"D": [0.1, -0.2, 0.01, 0.02, 0.3, *[0] * 9]}, [0.1, -0.2, 0.01, 0.02, 0.3]),
        ({"D": [0.1, -0.2, 0.01, 0.02, 0.3, 0.4, 0, 0, 0, 0]}, [0.1, -0.2, 0.01, 0.02, 0.3, 0.4, 0, 0]),
        ({"D": [0.1] * 12}, [0.1] * 12),
        ({"D": [0.0] * 3}, [0.0] * 5),
        ({"D": [0.0] * 20}, [0.0] * 5),
        ({"fl_x": 600, "k1": 0.1, "k2": 0, "p1": 0, "p2": 0, "k4": 0}, [0.1, 0, 0, 0, 0]),
        ("1 SIMPLE_RADIAL 640 480 600 320 240 0.1", [0.1, 0, 0, 0, 0]),
        ("1 RADIAL 640 480 600 320 240 0.1 -0.2", [0.1, -0.2, 0, 0, 0]),
        ("1 OPENCV 640 480 600 610 320 240 0.1 -0.2 0.01 0.02", [0.1, -0.2, 0.01, 0.02, 0]),
        ("1 PINHOLE 640 480 600 610 320 240", None),
        ({**FLAT, "depth_camera": {"fx": 300, "k1": 0.3}}, None),
        ({**FLAT, "dist_coeff": [[0.1, 0, 0, 0]]}, [0.1, 0, 0, 0, 0]),
        ({"distortion_coefficients": {"rows": 1, "cols": 5, "data": [0.1, *[0] * 4]}, "distortion_model": "plumb_bob"},
         [0.1, *[0] * 4]),
        ({"distortion": {"k1": 0.1, "k2": -0.2, "p1": 0.01, "p2": 0.02, "k3": 0}}, [0.1, -0.2, 0.01, 0.02, 0]),
        ({**FLAT, "camera_model": "D435i, left", "coeffs": [0.1, *[0] * 4], "model": "brown_conrady"}, [0.1, *[0] * 4]),
    ],
)  # fmt: skip
def test_lenses_of_other_tools(tmp_path: Path, said: object, found: list[float] | None) -> None:
    told = lens(tmp_path, said)
    assert told == pytest.approx(found) if found is not None else told is None


@pytest.mark.parametrize(
    ("said", "code", "says"),
    [
        ({**FLAT, "radial_distortion": [0.1, 0.2]}, "MODEL", "radialdistortion"),
        ({**FLAT, "RadialDistortion": [0.1, 0.2], "TangentialDistortion": [0, 0]}, "MODEL", "radialdistortion"),
        ({**FLAT, "lens": {"k1": 0.1}}, "MODEL", "lens"),
        ({"fl_x": 600, "k1": 0.1, "k4": 0.3}, "MODEL", "nerfstudio"),
        ({**FLAT, "k1": 0.1, "distortion_model": "division"}, "MODEL", "division"),
        ({"D": [0.1] * 15}, "MISSING", ""),
        ({"D": [0.1, 0.2]}, "MISSING", ""),
        ("1 OPENCV_FISHEYE 640 480 600 610 320 240 0.1 -0.2 0.01 0.02", "MODEL", "is of a fisheye lens"),
        ({"fl_x": 600, "camera_model": "OPENCV_FISHEYE", "k1": 0.1}, "MODEL", "is of a fisheye lens"),
        ({"D": [0.1] * 4, "distortion_model": "equidistant"}, "MODEL", "is of a fisheye lens"),
        ({"coeffs": [0.1] * 5, "model": "RS2_DISTORTION_KANNALA_BRANDT4"}, "MODEL", "cv2.fisheye"),
        ({**FLAT, "is_fisheye": True}, "MODEL", "is of a fisheye lens"),
        ({"D": ["much"]}, "MISSING", ""),
        ({"D": [1, 2, 3]}, "MISSING", ""),
        ({"D": [float("nan")] * 5}, "MISSING", ""),
    ],
)
def test_lenses_that_are_not_read_are_refused(tmp_path: Path, said: object, code: str, says: str) -> None:
    with refused(f"E-LENS-{code}", says):
        lens(tmp_path, said)


def test_the_first_of_kalibr_s_cameras_is_taken_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = {"cam0": {"intrinsics": [600, 610, 320, 240]}, "cam1": {"intrinsics": [500, 500, 320, 240]}}
    np.testing.assert_allclose(camera(tmp_path, said), K)
    assert "cam0 is taken" in capsys.readouterr().out


def test_camera_by_name() -> None:
    """A real D435 at 640x480 has fx 613; its narrow picture is cut at the sides of a wide sensor."""
    assert intrinsics_of_camera("realsense_d435", 640, 480)[0, 0] == pytest.approx(613, rel=0.02)
    assert intrinsics_of_camera("realsense_d435", 1280, 720)[0, 0] == pytest.approx(920, rel=0.02)
    assert intrinsics_of_camera("realsense_d435", 480, 640)[0, 0] == pytest.approx(613, rel=0.02), "held upright"
    for name, says in (
        ("polaroid", "there are: azure_kinect, "),
        ("realsense_d345", "did you mean 'realsense_d435'? (or "),
    ):
        with refused("E-CAMERA-NAME", says):
            intrinsics_of_camera(name, 640, 480)


def test_aliases_of_yaml_are_refused(tmp_path: Path) -> None:
    (tmp_path / "k.yaml").write_text("a: &a [1, 1]\nK: [*a, *a]\n")
    with refused("E-FILE-UNREADABLE", "aliases"):
        contents(tmp_path / "k.yaml")
