"""What tells the unit of depth, or that a pixel is unknown, or along what it is measured, is read, told or refused."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, PngImagePlugin

from roomkin.stages.contracts import Camera, read_json
from roomkin.stages.contracts.images import read_depth
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.depth_forms import along_axis, find_flatter, find_marks, ray_lengths
from roomkin.stages.perception import from_rgbd
from roomkin.stages.perception.read.depth_files import convert_to_metres, find_cut_range, read_raw
from roomkin.stages.perception.read.depth_scale import find_stated_units
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, INTRINSICS, OBJECT, trace, write_room

BOX = UprightBox([2.8, 0.2, 0.4], [0.6, 0.8, 0.8], 0.2)
FX = {"fx": float(INTRINSICS[0, 0]), "fy": float(INTRINSICS[1, 1]), "cx": 239.5, "cy": 179.5}


@pytest.fixture(scope="module")
def room() -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
    return trace([BOX])


def median_by(folder: Path, about: object, raw: NDArray[Any], name: str = "K.json") -> tuple[float, str]:
    """The median in metres of depth with a file beside it, and the line about it."""
    folder.mkdir(exist_ok=True)
    np.save(folder / "depth.npy", raw)
    (folder / name).write_text(about if isinstance(about, str) else json.dumps(about))
    metres, line = convert_to_metres(
        folder / "depth.npy", raw, "auto", find_stated_units(folder / "depth.npy", folder / name)
    )
    return float(np.median(metres[metres > 0])), line


@pytest.mark.parametrize(
    ("per_metre", "about"),
    [
        (4000, {**FX, "depth_scale": 4000.0}),  # Open3D
        (4000, {**FX, "depth_scale": 0.00025}),  # RealSense
        (10000, {**FX, "depth_scale": 0.1}),  # BOP, mm a unit
        (1000, {**FX, "depth_scale": 1.0}),
        (10000, {"0": {"cam_K": INTRINSICS.ravel().tolist(), "depth_scale": 0.1}}),
        (6553.5, {"camera": {**FX, "scale": 6553.5}}),  # Replica
        (6553.5, {"cam": {"png_depth_scale": 6553.5}}),
        (5000, "%YAML:1.0\nCamera.fx: 400.0\nRGBD.DepthMapFactor: 5000.0\n"),
        (8000, {"depth": {"scale": 0.000125, "width": 3}}),
        (1000, {"depth": {"unit": "mm"}}),
        (100, {"depth_unit": "centimeters"}),
        (1 / 0.3048, {"depth_units": "feet"}),
        (4000, {"param-depthunits": "250"}),  # of RealSense's viewer, micrometres
        (1000, "m_colorWidth = 480\nm_depthShift = 1000.000000\n"),
        (1000, {"depth_scale": 0.0010000000474974513, "depth_units": "mm"}),
        (5000, {"fl_x": 400.0, "integer_depth_scale": 0.0002}),
    ],
)
def test_the_scale_that_a_file_says_is_taken(
    tmp_path: Path, room: tuple[Any, Any], per_metre: float, about: object
) -> None:
    near = np.where(room[0] < 6, room[0], 0)
    whole = per_metre >= 1000
    raw = np.rint(near * per_metre).astype(np.uint16) if whole else (near * per_metre).astype(np.float32)
    found, line = median_by(tmp_path, about, raw)
    assert found == pytest.approx(float(np.median(near[near > 0])), rel=1e-3)
    assert " in K.json" in line


def test_what_says_something_else_is_not_taken_for_a_scale(tmp_path: Path, room: tuple[Any, Any]) -> None:
    raw = np.rint(room[0] * 1000).astype(np.uint16)
    for about in ({"scale": 0.33, "fl_x": 400.0}, {"scale": 4000.0}, {"units": "feet"}, {"depth_scale": "unknown"}):
        assert "found by its median" in median_by(tmp_path, about, raw)[1]


def test_a_file_beside_the_depth_says_it_too(tmp_path: Path, room: tuple[Any, Any]) -> None:
    raw = np.rint(room[0] * 4000).astype(np.uint16)
    (tmp_path / "depth").mkdir()
    np.save(tmp_path / "depth/1.npy", raw)
    (tmp_path / "camera.json").write_text(json.dumps({"depth_scale": 4000}))
    (tmp_path / "broken.json").write_text("{")
    (stated,) = find_stated_units(tmp_path / "depth/1.npy")
    assert str(stated) == "depth_scale 4000 in camera.json"


def test_the_depth_file_itself_says_it_first(tmp_path: Path) -> None:
    (tmp_path / "K.json").write_text(json.dumps({"depth_scale": 4000}))
    np.savez(tmp_path / "d.npz", depth=np.ones((4, 4)), depth_scale=0.001)
    info = PngImagePlugin.PngInfo()
    info.add_text("depth_scale", "0.0002")
    Image.fromarray(np.ones((4, 4), np.uint16)).save(tmp_path / "d.png", pnginfo=info)
    assert [one.where for one in find_stated_units(tmp_path / "d.npz", tmp_path / "K.json")] == ["d.npz"]
    assert [one.where for one in find_stated_units(tmp_path / "d.png", tmp_path / "K.json")] == ["d.png"]


def test_scales_that_contradict_the_depth_or_each_other_are_refused(tmp_path: Path, room: tuple[Any, Any]) -> None:
    raw = np.rint(np.where(room[0] < 6, room[0], 0) * 4000).astype(np.uint16)
    with refused("E-DEPTH-UNIT", "depth_scale 31 in K.json"):
        median_by(tmp_path / "a", {"png_depth_scale": 31} | {"depth_scale": 31}, raw)
    with refused("E-DEPTH-UNIT", "no depth of a room by depth_scale 1000000.0 in K.json", "--unit"):
        median_by(tmp_path / "a", {"depth_scale": 1e6}, raw)
    for name, scale in (("one.json", 4000), ("two.json", 5000)):
        (tmp_path / "a" / name).write_text(json.dumps({"depth_scale": scale}))
    (tmp_path / "a/K.json").unlink()
    with refused("E-DEPTH-UNIT", "--unit 4000", "--unit 5000") as caught:
        convert_to_metres(tmp_path / "a/depth.npy", raw, "auto", find_stated_units(tmp_path / "a/depth.npy"))
    assert "--unit mm" not in str(caught.value)


def test_a_unit_that_is_told_goes_before_the_file_and_says_so(room: tuple[Any, Any], tmp_path: Path) -> None:
    (tmp_path / "K.json").write_text(json.dumps({"depth_scale": 4000}))
    stated = find_stated_units(tmp_path / "d.npy", tmp_path / "K.json")
    raw = np.rint(room[0] * 1000).astype(np.uint16)
    assert "as stated, though depth_scale 4000 in K.json" in convert_to_metres(Path("d"), raw, "mm", stated)[1]
    assert "though" not in convert_to_metres(Path("d"), 4 * raw, "4000", stated)[1]


@pytest.mark.parametrize(
    ("dtype", "scale", "mark"),
    [(np.uint16, 1000, 65535), (np.int32, 1000, 65535), (np.int16, 1000, 32767), (np.uint16, 1000, 20000),
     (np.float32, 1, 65.535), (np.float32, 1, 0.001), (np.float32, 1, 99.0)],
)  # fmt: skip
def test_marks_of_the_unknown_are_no_distances(room: tuple[Any, Any], dtype: type, scale: float, mark: float) -> None:
    raw = (np.where((room[0] > 0) & (room[0] < 6), room[0], 3) * scale).astype(dtype)
    raw[100:150, 100:200] = mark
    metres, line = convert_to_metres(Path("d"), raw)
    assert not metres[100:150, 100:200].any() and (metres > 0).sum() == metres.size - 5000
    assert f"{mark:g} taken for unknown" in line


def test_depth_that_is_cut_off_at_a_range(room: tuple[Any, Any]) -> None:
    """At whole half metres, with a floor that goes on beyond: no wall."""
    depth = np.minimum(np.where(trace([BOX], wall=False)[0] > 0, trace([BOX], wall=False)[0], 50), 5.0)
    metres, line = convert_to_metres(Path("d"), np.rint(1000 * depth).astype(np.uint16))
    assert not metres[depth == 5].any() and metres[depth < 4.99].all() and "5000 taken for unknown" in line


def test_depth_that_is_cut_off_is_told_beside_a_wall_of_a_sensor() -> None:
    """A wall at two metres, in millimetres, has many equal values, too."""
    rng = np.random.default_rng(0)
    depth = np.tile(np.linspace(1, 9.9, 400), (300, 1)) * (1 + 0.002 * rng.standard_normal((300, 400)))
    depth[100:, :300] = 2 + 0.003 * rng.standard_normal((200, 300))
    depth[:50, 350:] = 10
    metres, line = convert_to_metres(Path("d"), np.rint(1000 * np.minimum(depth, 10)).astype(np.uint16))
    assert not metres[:50, 350:].any() and (metres[100:, :300] > 0).all() and "10000 taken for unknown" in line


def test_walls_and_fronts_that_are_seen_straight_on_stay(room: tuple[Any, Any]) -> None:
    flat = np.full((200, 300), 1.5, np.float32)
    flat[50:100, 50:100] = 0.6  # a box from above
    assert find_marks(flat) == []
    wall = np.minimum(trace([BOX], wall=False)[0], np.float32(3.8713))
    wall[wall == 0] = np.float32(3.8713)
    assert (convert_to_metres(Path("d"), wall)[0] > 0).all()


@pytest.mark.parametrize(("pixels", "found"), [(30, None), (150, None), (250, 10.0)])
def test_a_few_pixels_at_one_distance_are_no_range(pixels: int, found: float | None) -> None:
    """Of 100,000 pixels: what is cut off is seen in more than a patch."""
    depth = np.linspace(1, 6, 100_000).reshape(250, 400).astype(np.float32)
    depth.ravel()[:pixels] = 10.0
    assert find_cut_range(depth) == found


def test_bytes_are_no_millimetres(tmp_path: Path, room: tuple[Any, Any]) -> None:
    byte = np.clip(room[0] * 50, 1, 255).astype(np.uint8)
    np.save(tmp_path / "d.npy", byte)
    with refused("E-DEPTH-FORMAT", "16 bits"):
        read_raw(tmp_path / "d.npy")
    for dtype in (np.uint16, np.float32):
        with refused("E-DEPTH-UNIT", "bytes, not millimetres"):
            convert_to_metres(tmp_path / "d.npy", byte.astype(dtype))


def test_marks_in_an_input_folder(tmp_path: Path, room: tuple[Any, Any], capsys: pytest.CaptureFixture[str]) -> None:
    for raw, mark in ((np.rint(room[0] * 1000).astype(np.uint16), 65535), (room[0].copy(), 65.535)):
        raw[:50, :50] = mark
        np.savez(tmp_path / "depth.npz", depth=raw)
        assert not read_depth(tmp_path / "depth.npz")[0][:50, :50].any()
        assert f"{mark:g} is taken for unknown" in capsys.readouterr().out
    exact = np.minimum(room[0], 2.5)
    exact[:50, :50] = 9
    np.savez(tmp_path / "depth.npz", depth=exact)
    assert (read_depth(tmp_path / "depth.npz")[0][:50, :50] == 9).all(), "a drawn wall may be as far all over"


class Part:
    """What OpenEXR says of a part of a file."""

    def __init__(self, called: str, channels: dict[str, NDArray[np.float32]]) -> None:
        self.called, self.channels = called, channels
        self.header = {name: (np.array([0, 0]), np.array([29, 19])) for name in ("dataWindow", "displayWindow")}

    def name(self) -> str:
        return self.called


def exr(monkeypatch: pytest.MonkeyPatch, path: Path, *parts: Part) -> NDArray[Any]:
    path.write_bytes(b"v/1\x01")

    class File:
        def __init__(self, name: str, separate_channels: bool) -> None:
            assert name == str(path) and separate_channels
            self.parts = list(parts)

        def __enter__(self) -> "File":
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def channels(self, number: int) -> dict[str, SimpleNamespace]:
            return {name: SimpleNamespace(pixels=pixels) for name, pixels in parts[number].channels.items()}

    monkeypatch.setitem(sys.modules, "OpenEXR", SimpleNamespace(File=File))
    return read_raw(path)


DEPTH, OTHER, THIRD = (np.full((20, 30), value, np.float32) for value in (1.25, 0.5, 0.7))


@pytest.mark.parametrize(
    "channels",
    [
        {"R": DEPTH},
        {"anything": DEPTH},
        {"R": DEPTH, "G": DEPTH, "B": DEPTH},
        {"A": OTHER, "B": OTHER, "G": THIRD, "R": OTHER, "Z": DEPTH},
        {"Combined.R": OTHER, "Combined.G": THIRD, "Combined.B": OTHER, "ViewLayer.Depth.V": DEPTH},
        {"ViewLayer.Depth.Z": DEPTH, **{f"ViewLayer.Normal.{axis}": OTHER for axis in "XYZ"}},
        {"depth.R": DEPTH, "depth.G": DEPTH, "depth.B": DEPTH, "color.R": OTHER, "color.G": THIRD, "color.B": OTHER},
        {"A": OTHER, "depth": DEPTH},
    ],
)
def test_the_channel_of_depth_is_told_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, channels: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert np.array_equal(exr(monkeypatch, tmp_path / "d.exr", Part("", channels)), DEPTH)
    assert ("depth is its channel" in capsys.readouterr().out) == (len(channels) > 1)


@pytest.mark.parametrize(
    "channels",
    [
        {"A": OTHER, "B": DEPTH},
        {"R": OTHER, "G": THIRD, "B": DEPTH},
        {"left.Z": OTHER, "right.Z": DEPTH},
        {"Position.X": OTHER, "Position.Y": THIRD, "Position.Z": DEPTH},
    ],
)
def test_channels_that_may_all_be_depth_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, channels: dict[str, Any]
) -> None:
    with refused("E-DEPTH-FORMAT", "which of them is depth"):
        exr(monkeypatch, tmp_path / "d.exr", Part("", channels))


def test_parts_of_an_exr_and_no_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = Part("beauty", {"R": OTHER, "G": THIRD, "B": OTHER}), Part("depth", {"Y": DEPTH})
    assert np.array_equal(exr(monkeypatch, tmp_path / "d.exr", *parts), DEPTH)
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with refused("E-LIBRARY-MISSING"):
        read_raw(tmp_path / "d.exr")


def test_a_window_of_an_exr_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    part = Part("", {"Z": DEPTH})
    part.header["displayWindow"] = (np.array([0, 0]), np.array([39, 19]))
    with refused("E-DEPTH-SIZE", "displayWindow"):
        exr(monkeypatch, tmp_path / "d.exr", part)


def test_numbers_of_a_pgm_are_those_in_the_file(tmp_path: Path) -> None:
    numbers = np.arange(1, 401, dtype=">u2").reshape(20, 20) * np.array(25, ">u2")
    (tmp_path / "d.pgm").write_bytes(b"P5\n# depth\n20 20\n10000\n" + numbers.astype(">u2").tobytes())
    assert np.array_equal(read_raw(tmp_path / "d.pgm"), numbers)


def test_several_pages_of_a_tiff_are_refused(tmp_path: Path) -> None:
    pages = [Image.fromarray(np.full((20, 20), value, np.uint16)) for value in (1000, 2000)]
    pages[0].save(tmp_path / "d.tif", save_all=True, append_images=pages[1:])
    with refused("E-DEPTH-FORMAT", "2 pages"):
        read_raw(tmp_path / "d.tif")


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_distance_along_the_ray_is_doubted_and_can_be_told(room: tuple[Any, Any], noise: float) -> None:
    """Floor and wall bend; depth along the axis, and what has been converted, is not doubted."""
    rng = np.random.default_rng(0)
    depth = (room[0] * (1 + noise * rng.standard_normal(room[0].shape))).astype(np.float32)
    distance = (depth * ray_lengths(depth.shape, INTRINSICS)).astype(np.float32)
    assert find_flatter(depth, INTRINSICS) == "" and find_flatter(distance, INTRINSICS) == "ray"
    assert find_flatter(along_axis(depth, INTRINSICS), INTRINSICS) == "axis"
    np.testing.assert_allclose(along_axis(distance, INTRINSICS), depth, rtol=1e-5)


def test_depth_is_ray_as_an_option(tmp_path: Path, room: tuple[Any, Any], capsys: pytest.CaptureFixture[str]) -> None:
    depth, masks = room
    cv2.imwrite(str(tmp_path / "rgb.png"), np.dstack([masks * 20] * 3).astype(np.uint8))
    cv2.imwrite(str(tmp_path / "masks.png"), masks)
    (tmp_path / "names.json").write_text(json.dumps({str(FLOOR): "floor", str(OBJECT): "box"}))
    (tmp_path / "K.json").write_text(json.dumps(INTRINSICS.tolist()))
    np.save(tmp_path / "d.npy", depth * ray_lengths(depth.shape, INTRINSICS))
    files: dict[str, Any] = {"rgb": "rgb.png", "depth": "d.npy", "masks": "masks.png",
                             "labels": "names.json"}  # fmt: skip
    given = {key: tmp_path / name for key, name in files.items()} | {"camera": (str(tmp_path / "K.json"),)}
    from_rgbd.run(out=tmp_path / "z", **given)
    assert "depth in doubt: floor and walls would be flat with --depth-is ray" in capsys.readouterr().out
    assert "in doubt" in read_json(Camera, tmp_path / "z/camera.json").note
    read_scene_input(tmp_path / "z")
    assert "in doubt" in capsys.readouterr().out
    from_rgbd.run(out=tmp_path / "ray", depth_is="ray", **given)
    found = read_scene_input(tmp_path / "ray").depth
    assert "in doubt" not in capsys.readouterr().out
    assert np.abs(found - depth)[found > 0].max() < 1e-4 and read_json(Camera, tmp_path / "ray/camera.json").note == ""


@pytest.mark.parametrize("shown", ["black", "transparent"])
def test_a_picture_that_shows_nothing_is_no_input(tmp_path: Path, shown: str) -> None:
    write_room(tmp_path, [BOX], ["box"])
    picture = np.zeros((360, 480, 4), np.uint8)
    if shown == "black":
        picture[..., 3] = 255
    else:
        picture[..., :3] = np.random.default_rng(0).integers(0, 255, (360, 480, 3))
    cv2.imwrite(str(tmp_path / "rgb.png"), picture)
    with refused("E-PICTURE-BLANK"):
        read_scene_input(tmp_path)
