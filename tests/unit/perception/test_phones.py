"""Recordings of phones as Stray Scanner saves them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from roomkin.stages.config.recordings import list_frames
from roomkin.stages.perception.read.views import choose_camera, find_view, read_frame
from tests.refusals import refused

K = "60.0, 0.0, 31.5\n0.0, 60.0, 23.5\n0.0, 0.0, 1.0\n"
RGB = np.random.default_rng(0).integers(0, 255, (48, 64, 3), dtype=np.uint8)
DEPTH = np.full((24, 32), 2000, np.uint16) + np.arange(32, dtype=np.uint16)
SURE = np.full((24, 32), 2, np.uint8)
SURE[:, :8] = 0


def stray(folder: Path, depth: str = ".png", first: int | None = 0) -> Path:
    """A recording of three frames; first: the number of the first picture, None: the video is not cut."""
    (folder / "rgb.mp4").parent.mkdir()
    (folder / "rgb.mp4").write_bytes(b"\0\0\0\x18ftypmp42")
    (folder / "camera_matrix.csv").write_text(K)
    (folder / "odometry.csv").write_text("timestamp, frame, x, y, z, qx, qy, qz, qw\n")
    for name, array in (("depth", DEPTH), ("confidence", SURE)):
        (folder / name).mkdir()
        for k in range(3):
            path = folder / name / f"{k:06}{depth}"
            np.save(path, array) if depth == ".npy" else Image.fromarray(array).save(path)
    if first is not None:
        (folder / "rgb").mkdir()
        for k in range(3):
            Image.fromarray(RGB).save(folder / f"rgb/{first + k:06}.jpg")
    return folder


def test_pictures_that_are_fewer_than_depth_keep_their_numbers(tmp_path: Path) -> None:
    recording = stray(tmp_path / "rec", first=1)
    (recording / "rgb/000003.jpg").unlink()
    assert [(a.stem, b.stem) for a, b in list_frames(recording)] == [("000001",) * 2, ("000002",) * 2]


@pytest.mark.parametrize("depth", [".png", ".npy"])
@pytest.mark.parametrize("first", [0, 1])
def test_a_recording_of_stray_scanner(tmp_path: Path, depth: str, first: int) -> None:
    view = find_view(stray(tmp_path / "rec", depth, first), 2, None)
    assert (view.color.stem, view.depth.stem) == (f"{first + 2:06}", "000002"), "ffmpeg counts from 1 if not told"
    frame = read_frame(view, "auto", "z", None, None)
    assert frame.intrinsics[0, 0] == 60 and frame.depth[20, 40] == pytest.approx(2.02, abs=0.01)
    assert not frame.depth[:, :15].any() and frame.depth[:, 17:].all(), "what is of low confidence is unknown"
    said = "; ".join(frame.notes)
    for words in ("25 % of it left out, of low confidence", "of camera_matrix.csv", "odometry.csv is not read"):
        assert words in said


def test_without_confidence_all_depth_is_kept(tmp_path: Path) -> None:
    recording = stray(tmp_path / "rec")
    (recording / "confidence/000001.png").unlink()
    frame = read_frame(find_view(recording, 1, None), "auto", "z", None, None)
    assert frame.depth.all() and "confidence" not in "; ".join(frame.notes)


def test_a_frame_alone_has_its_camera_from_camera_matrix_csv(tmp_path: Path) -> None:
    reader, file = choose_camera([str(stray(tmp_path / "rec") / "camera_matrix.csv")])
    assert reader and file and reader(64, 48, "a.jpg").intrinsics[1, 1] == 60


@pytest.mark.parametrize("name", ["rec", "my rec"])
def test_a_video_is_to_be_cut(tmp_path: Path, name: str) -> None:
    recording = stray(tmp_path / name, first=None)
    with refused("E-RECORDING-VIDEO", "a video, rgb.mp4. Fix: ", "ffmpeg -i ", " -start_number 0 ") as caught:
        list_frames(recording)
    assert (f"'{recording}/rgb'/" if " " in name else f"{recording}/rgb/") in str(caught.value)
    (recording / "rgb.mp4").unlink()
    with refused("E-RECORDING-LAYOUT", "Stray Scanner"):
        list_frames(recording)


def write(path: str, text: str) -> Callable[[Path], Any]:
    return lambda recording: (recording / path).write_text(text)


@pytest.mark.parametrize(
    ("fault", "code", "says"),
    [
        (write("camera_matrix.csv", K[:40]), "E-CAMERA-INTRINSICS", "holds intrinsics that"),
        (write("camera_matrix.csv", ""), "E-CAMERA-INTRINSICS", "camera_matrix.csv: holds no intrinsics"),
        (write("camera_matrix.csv", K.replace("31.5", "959")), "E-CAMERA-INTRINSICS", "camera_matrix.csv: "),
        (lambda recording: (recording / "camera_matrix.csv").unlink(), "E-CAMERA-MISSING", "no file of intrinsics"),
        (write("confidence/000000.png", "no"), "E-IMAGE-UNREADABLE", "confidence/000000.png"),
        (
            lambda recording: Image.fromarray(SURE[:20]).save(recording / "confidence/000000.png"),
            "E-DEPTH-SIZE",
            "000000.png: has shape (20, 32), the depth (24, 32)",
        ),
        (
            lambda recording: Image.fromarray(0 * SURE).save(recording / "confidence/000000.png"),
            "E-DEPTH-EMPTY",
            "no pixel has a depth",
        ),
        (lambda recording: (recording / "rgb/000000.jpg").rename(recording / "rgb/7.jpg"), "", ""),
    ],
)
def test_faults_of_a_recording(tmp_path: Path, fault: Callable[[Path], Any], code: str, says: str) -> None:
    recording = stray(tmp_path / "rec")
    fault(recording)
    if not code:  # two of three have a partner
        assert [picture.stem for picture, _ in list_frames(recording)] == ["000001", "000002"]
        return
    with refused(code, says):
        read_frame(find_view(recording, 0, None), "auto", "z", None, None)
