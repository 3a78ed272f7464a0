"""RGB-D frames of other people's cameras and data sets become input folders (`perception from-rgbd`)."""

import json
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts import Camera, InputError, read_json
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.extraction.corrected_masks import Cutter, correct_masks
from roomkin.stages.extraction.noise import read_folder
from roomkin.stages.extraction.reconstruct import reconstruct
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception import from_rgbd
from roomkin.stages.perception.classification.propose import LikelyName
from roomkin.stages.perception.read.depth_files import convert_to_metres, read_raw
from roomkin.stages.perception.read.frame import Labelled
from roomkin.stages.perception.read.mask_files import read_labelled
from roomkin.stages.perception.read.views import find_view, list_frames
from roomkin.stages.perception.write import make_annotations
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WIDTH, trace

ROOT = Path(__file__).resolve().parents[3]

TABLE = UprightBox([2.5, 0.0, 0.35], [1.8, 2.2, 0.7], 0.0)
BOX = UprightBox([2.4, 0.4, 0.8], [0.2, 0.3, 0.2], 0.3)
CAN = UprightBox([2.5, -0.35, 0.85], [0.15, 0.15, 0.3], 0.0)
DATA = Path(os.environ.get("ACDC_TEST_DATA", Path(__file__).resolve().parents[4] / "shared/data"))
REAL = DATA / "rgbd" / "uois_realsense_tabletop"


@pytest.fixture(scope="module")
def room() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Picture, depth in metres and masks of a table with a box and a can."""
    depth, masks = trace([TABLE, BOX, CAN], wall=False)
    rgb = np.stack([masks * 17 % 255, masks * 29 % 255, np.arange(WIDTH) % 255 + 0 * masks], axis=-1).astype(np.uint8)
    return rgb, depth, masks


@pytest.fixture
def files(tmp_path: Path, room: tuple) -> SimpleNamespace:
    """The frame as files: color, depth in millimetres, intrinsics, masks with names."""
    rgb, depth, masks = room
    cv2.imwrite(str(tmp_path / "color.png"), rgb[..., ::-1])
    cv2.imwrite(str(tmp_path / "depth.png"), np.rint(1000 * depth).astype(np.uint16))
    cv2.imwrite(str(tmp_path / "masks.png"), masks)
    names = {FLOOR: "floor", OBJECT: "table", OBJECT + 1: "box", OBJECT + 2: "cabinet"}
    (tmp_path / "names.json").write_text(json.dumps({str(value): name for value, name in names.items()}))
    (tmp_path / "K.txt").write_text(" ".join(map(str, INTRINSICS.ravel())))
    return SimpleNamespace(**{path.stem: path for path in tmp_path.iterdir()}, folder=tmp_path)


def test_files_become_an_input_folder(files: SimpleNamespace, capsys: pytest.CaptureFixture[str]) -> None:
    out = files.folder / "mine"
    from_rgbd.run(
        out=out, rgb=files.color, depth=files.depth, camera=(str(files.K),), masks=files.masks, labels=files.names
    )
    given = read_scene_input(out)
    assert {item.label for item in given.annotations.objects} == {"table", "box", "cabinet"}
    assert [item.label for item in given.annotations.objects if item.articulated] == ["cabinet"]
    assert given.annotations.floor == FLOOR and not given.exact
    assert yaml.safe_load((out / "config.yaml").read_text())["experiment"]["inputs"] == {"mine": str(out)}
    said = capsys.readouterr().out
    assert "depth in mm (found by its median" in said and "doors and drawers there are: cabinet" in said


def test_a_picture_is_called_as_its_file_unless_all_are_called_so(files: SimpleNamespace) -> None:
    options: dict[str, Any] = {"depth": files.depth, "camera": (str(files.K),)}
    for name, called in (("Küche 2.png", "Küche 2"), ("color.png", "")):
        picture = files.folder / "there" / name
        picture.parent.mkdir(exist_ok=True)
        shutil.copy(files.color, picture)
        from_rgbd.run(out=files.folder / "called", rgb=picture, **options)
        assert read_json(Camera, files.folder / "called/camera.json").picture == called


def test_depth_of_another_size_is_laid_on_the_picture(files: SimpleNamespace, room: tuple) -> None:
    small = cv2.resize(room[1], (WIDTH // 3, HEIGHT // 3), interpolation=cv2.INTER_NEAREST)
    np.save(files.folder / "small.npy", small)
    options: dict[str, Any] = {"rgb": files.color, "camera": ("55",), "masks": files.masks, "labels": files.names}
    from_rgbd.run(out=files.folder / "a", depth=files.folder / "small.npy", **options)
    depth = read_scene_input(files.folder / "a").depth
    assert depth.shape == (HEIGHT, WIDTH)
    assert np.median(np.abs(depth - room[1])) < 0.02
    np.save(files.folder / "square.npy", small[:, : HEIGHT // 3])
    with refused("E-DEPTH-SIZE"):
        from_rgbd.run(out=files.folder / "b", depth=files.folder / "square.npy", **options)
    assert not (files.folder / "b").exists()


def test_intrinsics_may_be_told_as_numbers(files: SimpleNamespace) -> None:
    told = tuple(map(str, INTRINSICS[[0, 1, 0, 1], [0, 1, 2, 2]].tolist()))
    options: dict[str, Any] = {"rgb": files.color, "depth": files.depth, "masks": files.masks, "labels": files.names}
    from_rgbd.run(out=files.folder / "a", camera=told, **options)
    assert read_scene_input(files.folder / "a").camera.intrinsics == INTRINSICS.tolist()
    for wrong in (told[:3], (*told[:3], "5000"), ("30", *told[1:])):
        with refused("E-CAMERA-INTRINSICS"):
            from_rgbd.run(out=files.folder / "b", camera=wrong, **options)


def test_without_masks_the_page_is_named(files: SimpleNamespace, capsys: pytest.CaptureFixture[str]) -> None:
    out = files.folder / "bare one"
    from_rgbd.run(out=out, rgb=files.color, depth=files.depth, camera=(str(files.K),))
    assert sorted(path.name for path in out.iterdir()) == ["camera.json", "depth.npz", "rgb.png"]
    told = capsys.readouterr().out
    assert f"annotate '{out}'; or" in told and f"--picture '{out}' --out" in told


def boxes_of(folder: Path) -> dict[str, Any]:
    image = read_folder(folder)
    options = ExtractionConfig(depth_noise="none", crop=1.0)
    found = reconstruct("mine", image, options, np.random.default_rng(0)).objects
    return {"up": found.floor_from_camera[2][3], **{item.id: item.box for item in found.objects}}


def test_a_name_that_is_not_sure_is_doubted_until_it_is_said() -> None:
    sure, unsure = [LikelyName("mug", 0.95), LikelyName("jar", 0.01)], [LikelyName("jar", 0.4), LikelyName("mug", 0.3)]
    values = np.repeat(np.arange(3, dtype=np.uint16)[:, None], 4, axis=1)
    masks = Labelled(values, {1: "mug", 2: "jar"}, {1: sure, 2: unsure})
    _, written = make_annotations(masks)
    assert [item.proposals for item in written.objects] == [["mug", "jar"], ["jar", "mug"]]
    named, (doubt,) = (item.doubts for item in written.objects)
    assert named == []
    assert doubt.cause == "name" and doubt.what == "called jar by looks, size and place, 40 % sure; else mug"
    for said, left in (({"doors": 0}, [doubt]), ({"named": True}, []), ({"label": "vase"}, [])):
        change = {2: Correction.model_validate({"mask": 2, **said})}
        corrected, _, _ = correct_masks(written, values, change, Cutter(np.zeros((3, 4, 3), np.uint8)))
        assert corrected is not None and corrected.objects[1].doubts == left


def test_ground_is_what_the_named_things_stand_on(files: SimpleNamespace) -> None:
    """Masks of the things on a table alone: not the floor, though it is seen, too."""
    names = {str(OBJECT + 1): "box", str(OBJECT + 2): "can"}
    files.names.write_text(json.dumps(names))
    out = files.folder / "table"
    from_rgbd.run(
        out=out, rgb=files.color, depth=files.depth, camera=(str(files.K),), masks=files.masks, labels=files.names
    )
    assert boxes_of(out)["can_1"].size[2] == pytest.approx(CAN.size[2], abs=0.02)


@pytest.mark.parametrize(
    ("scale", "dtype", "unit", "says"),
    [
        (1, np.float32, "auto", "depth in m (found"),
        (1000, np.uint16, "auto", "depth in mm (found"),
        (1000, np.float64, "auto", "depth in mm (found"),
        (5000, np.uint16, "5000", "depth in 1/5000 m (as stated"),
        (1000, np.int32, "mm", "depth in mm (as stated"),
    ],
)
def test_unit_of_depth(room: tuple, scale: float, dtype: type, unit: str, says: str) -> None:
    near = np.where(room[1] < 10, room[1], 0)
    metres, line = convert_to_metres(Path("d.png"), (near * scale).astype(dtype), unit)
    assert line.startswith(says)
    assert np.abs(metres - near).max() < 0.002


def test_inverse_depth_and_another_unit_are_told(room: tuple) -> None:
    with pytest.raises(InputError, match="looks like inverse depth"):
        convert_to_metres(Path("d.npy"), np.where(room[1] > 0, 1 / np.maximum(room[1], 1e-3), 0))
    with refused("E-DEPTH-UNIT", "m in millimetres", "m in 1/4000 m", "--unit 4000, --unit 5000"):
        convert_to_metres(Path("d.png"), np.rint(5000 * room[1]).astype(np.uint16))
    assert np.allclose(convert_to_metres(Path("d.png"), np.rint(5000 * room[1]), "5000")[0], room[1], atol=1e-3)


@pytest.mark.parametrize(("near", "far"), [(0.025, 125), (0.1, 10), (0.01, 100), (0.5, 20)])
def test_a_z_buffer_is_told_with_what_makes_metres_of_it(room: tuple, near: float, far: float) -> None:
    depth = np.where(room[1] > 0, np.clip(room[1], near, far), far)
    value = (far / (far - near) * (1 - near / depth)).astype(np.float32)
    with refused("E-DEPTH-ZBUFFER", "near * far / (far - value * (far - near))"):
        convert_to_metres(Path("d.npy"), value)
    for other in (1 - value, np.rint(65534 * value).astype(np.uint16)):
        with pytest.raises(InputError, match=r"inverse depth|far - value"):
            convert_to_metres(Path("d.png"), other)
    by_mujoco = near / (1 - value.astype(float) * (1 - near / far))
    by_us = near * far / (far - value.astype(float) * (far - near))
    assert np.allclose(by_us, by_mujoco) and np.allclose(by_us, depth, rtol=0.02)


def test_metres_below_one_are_no_z_buffer(room: tuple) -> None:
    noise = np.random.default_rng(0).normal(0, 0.001, room[1].shape)
    for near in (room[1] / room[1].max(), room[1] / room[1].max() + noise, np.float16(room[1] / 20)):
        assert convert_to_metres(Path("d.npy"), np.where(room[1] > 0, near, 0).astype(float))[1].startswith(
            "depth in m "
        )


@pytest.mark.parametrize("axes", [(0,), (0, 1)])
@pytest.mark.parametrize("named", [True, False])
def test_a_frame_upside_down_with_its_depth_is_told(files: SimpleNamespace, axes: tuple[int, ...], named: bool) -> None:
    for path in (files.color, files.depth, files.masks):
        cv2.imwrite(str(path), np.flip(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), axes))
    masks = {"masks": files.masks, "labels": files.names} if named else {}
    words = "called floor lies above the camera" if named else "no level surface that faces up"
    with refused("E-PICTURE-UPSIDE-DOWN", words, "by 180 degrees", "flip them top to bottom"):
        from_rgbd.run(out=files.folder / "o", rgb=files.color, depth=files.depth, camera=(str(files.K),), **masks)


@pytest.mark.parametrize(("factor", "unit"), [(1e-3, "auto"), (1e6, "auto"), (1, "mm"), (1, "zero"), (0, "auto")])
def test_no_depth_of_a_room(room: tuple, factor: float, unit: str) -> None:
    with pytest.raises(InputError):
        convert_to_metres(Path("d.png"), room[1] * factor, unit)


def test_holes_and_nonsense_in_depth_are_unknown() -> None:
    depth = np.full((20, 20), 1.5)
    depth[0] = [np.nan, np.inf, -1, 0, 500] * 4
    metres, _ = convert_to_metres(Path("d.npy"), depth)
    assert (metres[0] == 0).all() and (metres[1:] == np.float32(1.5)).all()


@pytest.mark.parametrize("suffix", [".png", ".tiff", ".pgm", ".npz", ".npy"])
def test_depth_files(tmp_path: Path, room: tuple, suffix: str) -> None:
    path = tmp_path / f"depth{suffix}"
    stored = np.rint(1000 * room[1]).astype(np.uint16)
    if suffix == ".npz":
        np.savez(path, depth=stored)
    elif suffix == ".npy":
        np.save(path, stored)
    else:
        cv2.imwrite(str(path), stored)
    assert np.array_equal(read_raw(path), stored)


def test_a_picture_of_depth_is_refused(tmp_path: Path, room: tuple) -> None:
    cv2.imwrite(str(tmp_path / "pretty.png"), room[0])
    with refused("E-DEPTH-FORMAT"):
        read_raw(tmp_path / "pretty.png")


@pytest.mark.parametrize(
    ("content", "code"),
    [
        ({"shapes": []}, "MASKS-EMPTY"),
        ({"shapes": [{"label": "a"}]}, "FILE-UNREADABLE"),
        ({"annotations": [], "categories": [], "images": [{"id": 1, "width": 5, "height": 5}]}, "MASKS-SIZE"),
    ],
)
def test_broken_masks_are_one_line(tmp_path: Path, content: object, code: str) -> None:
    (tmp_path / "m.json").write_text(json.dumps(content))
    with refused(f"E-{code}"):
        read_labelled(tmp_path / "m.json", None, WIDTH, HEIGHT, "a.png")


def tum(folder: Path, rgb: np.ndarray, depth: np.ndarray, masks: np.ndarray) -> Path:
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
    cv2.imwrite(str(folder / "rgb" / "1.000.png"), rgb[..., ::-1])
    cv2.imwrite(str(folder / "depth" / "1.010.png"), np.rint(depth * 5000).clip(0, 65535).astype(np.uint16))
    (folder / "rgb.txt").write_text("# color images\n1.000 rgb/1.000.png\n9.000 rgb/9.png\n")
    (folder / "depth.txt").write_text("# depth maps\n0.5 depth/none.png\n1.010 depth/1.010.png\n")
    return folder


def open3d(folder: Path, rgb: np.ndarray, depth: np.ndarray, masks: np.ndarray) -> Path:
    for name in ("color", "depth"):
        (folder / name).mkdir(parents=True)
    cv2.imwrite(str(folder / "color" / "000000.jpg"), rgb[..., ::-1])
    cv2.imwrite(str(folder / "depth" / "000000.png"), np.rint(depth * 1000).astype(np.uint16))
    about = {"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": INTRINSICS.T.ravel().tolist()}
    (folder / "camera_intrinsic.json").write_text(json.dumps(about))
    return folder


def about_record3d() -> dict[str, Any]:
    coefficients = [INTRINSICS[0, 0], INTRINSICS[1, 1], INTRINSICS[0, 2], INTRINSICS[1, 2]]
    size = {"w": WIDTH, "h": HEIGHT, "dw": WIDTH // 2, "dh": HEIGHT // 2}
    return size | {"K": INTRINSICS.T.ravel().tolist(), "perFrameIntrinsicCoeffs": [coefficients]}


def record3d(folder: Path, rgb: np.ndarray, depth: np.ndarray, masks: np.ndarray) -> Path:
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
    cv2.imwrite(str(folder / "rgb" / "0.jpg"), rgb[..., ::-1])
    np.save(folder / "depth" / "0.npy", depth[::2, ::2])
    (folder / "metadata.json").write_text(json.dumps(about_record3d()))
    return folder


def test_frames_go_by_their_numbers_or_times(tmp_path: Path) -> None:
    folder, tum_folder = tmp_path / "numbered", tmp_path / "timed"
    files = [folder / name for name in ("color/9.jpg", "color/10.jpg", "depth/9.png", "depth/10.png")]
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    assert list_frames(folder) == [(files[0], files[2]), (files[1], files[3])]
    with refused("E-RECORDING-FRAME"):
        find_view(folder, -1, None)
    files[3].unlink()
    assert list_frames(folder) == [(files[0], files[2])]
    tum_folder.mkdir()
    (tum_folder / "rgb.txt").write_text("1.000 a.png\n2.000 b.png\n")
    (tum_folder / "depth.txt").write_text("1.015 c.png\n2.030 d.png\n")  # 30 ms are too many
    assert list_frames(tum_folder) == [(tum_folder / "a.png", tum_folder / "c.png")]


def write_lists(folder: Path, colors: Sequence[float], depths: Sequence[float]) -> Path:
    """Lists as TUM has them; files are called by their place."""
    folder.mkdir(exist_ok=True)
    for name, stamps in (("rgb", colors), ("depth", depths)):
        lines = (f"{stamp:.4f} {name}/{k}.png\n" for k, stamp in enumerate(stamps))
        (folder / f"{name}.txt").write_text("".join(lines))
    return folder


def test_pictures_of_a_list_go_with_the_nearest_depth_in_any_order(tmp_path: Path) -> None:
    """As each compared with all of them."""
    rng = np.random.default_rng(0)
    for count in (1, 2, 3, 50):
        colors, depths = (np.round(rng.uniform(0, 0.03 * count, count), 4) for _ in range(2))
        nearest = [int(np.abs(depths - stamp).argmin()) for stamp in colors]
        expected = [(str(k), str(near)) for k, near in enumerate(nearest) if abs(depths[near] - colors[k]) <= 0.02]
        found = list_frames(write_lists(tmp_path, colors, depths)) if expected else []
        assert [(color.stem, depth.stem) for color, depth in found] == expected
    many = 40_000  # each compared with all of them would be minutes
    for name in ("rgb", "depth"):
        (tmp_path / f"{name}.txt").write_text("".join(f"{k} {k}.png\n" for k in range(many)))
    assert len(list_frames(tmp_path)) == many


@pytest.mark.parametrize(("colors", "depths"), [((), ()), ((1.0,), ()), ((), (1.0,)), ((1.0, 2.0), (1.03, 7.0))])
def test_lists_that_pair_nothing_are_refused(
    tmp_path: Path, colors: tuple[float, ...], depths: tuple[float, ...]
) -> None:
    with refused("E-RECORDING-LAYOUT", "no picture of its rgb.txt"):
        list_frames(write_lists(tmp_path, colors, depths))


@pytest.mark.parametrize("name", ["/etc/hostname", "../other/a.png", "rgb/../../a.png", ".."])
@pytest.mark.parametrize("lists", ["rgb.txt", "depth.txt"])
def test_lists_that_name_files_outside_of_the_recording_are_refused(tmp_path: Path, name: str, lists: str) -> None:
    write_lists(tmp_path, [1.0], [1.0])
    (tmp_path / lists).write_text(f"1.0 {name}\n")
    with refused("E-FILE-OUTSIDE", f"{lists}: names '{name}'", "outside of the recording"):
        list_frames(tmp_path)


def test_a_broken_list_is_refused(tmp_path: Path) -> None:
    (write_lists(tmp_path, [1.0], [1.0]) / "rgb.txt").write_text("1.0\n")
    with refused("E-FILE-UNREADABLE", "rgb.txt"):
        list_frames(tmp_path)


@pytest.mark.parametrize("layout", [tum, open3d, record3d])
def test_recordings(tmp_path: Path, room: tuple, layout: Callable[..., Path]) -> None:
    recording, out = layout(tmp_path / "recording", *room), tmp_path / "out"
    from_rgbd.run(out=out, recording=recording)
    with np.load(out / "depth.npz") as stored:
        depth = stored["depth"]
    close = np.abs(depth - room[1])[(depth > 0) & (room[1] < 8)]
    assert np.quantile(close, 0.9) < 0.05 and len(close) > 0.5 * depth.size
    fx = read_json(Camera, out / "camera.json").intrinsics[0][0]
    assert fx == pytest.approx(525 * WIDTH / 640 if layout is tum else INTRINSICS[0, 0])
    with refused("E-RECORDING-FRAME"):
        from_rgbd.run(out=out, recording=recording, number=5)


@pytest.mark.parametrize("layout", [tum, open3d])
def test_the_unit_of_a_recording_can_be_told(tmp_path: Path, room: tuple, layout: Callable[..., Path]) -> None:
    recording, per_metre = layout(tmp_path / "recording", *room), 5000 if layout is tum else 1000
    for unit in ("auto", str(per_metre), str(2 * per_metre)):
        from_rgbd.run(out=tmp_path / unit, recording=recording, unit=unit)
    found = []
    for unit in ("auto", str(per_metre), str(2 * per_metre)):
        with np.load(tmp_path / unit / "depth.npz") as stored:
            found.append(float(np.median(stored["depth"][stored["depth"] > 0])))
    assert found[0] == found[1] == pytest.approx(2 * found[2], rel=0.01)


def test_the_lens_of_a_recording(tmp_path: Path, room: tuple, capsys: pytest.CaptureFixture[str]) -> None:
    recording = open3d(tmp_path / "recording", *room)
    file = next(recording.glob("*intrinsic*"))
    file.write_text(json.dumps(json.loads(file.read_text()) | {"coeffs": [-0.2, 0, 0, 0, 0], "model": "brown_conrady"}))
    from_rgbd.run(out=tmp_path / "out", recording=recording)
    assert "distortion is taken out" in capsys.readouterr().out
    from_rgbd.run(out=tmp_path / "out", recording=recording, camera=("55",))
    assert "distortion" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({}, "OPTION-MISSING"),
        ({"recording": Path("nothing")}, "RECORDING-LAYOUT"),
        ({"recording": ROOT / "tests"}, "RECORDING-LAYOUT"),
        ({"recording": ROOT / "tests", "rgb": Path("a")}, "OPTION-CONFLICT"),
        ({"rgb": Path("a.png"), "depth": Path("b.png"), "camera": ("xtion", "50")}, "CAMERA-INTRINSICS"),
        ({"rgb": Path("a.png"), "depth": Path("b.png")}, "CAMERA-MISSING"),
    ],
)
def test_what_does_not_go_together(tmp_path: Path, given: dict[str, Any], code: str) -> None:
    with refused(f"E-{code}"):
        from_rgbd.run(out=tmp_path / "out", **given)
    assert not (tmp_path / "out").exists()
