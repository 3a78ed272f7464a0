"""Extraction on ray-traced rooms with known boxes: frame, boxes, mounting types, bad input."""

import hashlib
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.config.packages import load_command
from roomkin.stages.contracts import Objects, read_json
from roomkin.stages.contracts.__main__ import main as check_contract
from roomkin.stages.contracts.files import digest_of
from roomkin.stages.contracts.objects import Mounting
from roomkin.stages.extraction.extract import merge_own_options, run
from roomkin.stages.extraction.noise import read_folder
from roomkin.stages.geometry.boxes import UprightBox, oriented_iou
from roomkin.stages.geometry.frames import invert_transform, transform_points, wrap_angle, yaw_of_matrix
from tests.packages import needs
from tests.refusals import refused
from tests.unit.synthetic_room import BACK_WALL, INTRINSICS, OBJECT, WALL, WORLD_FROM_CAMERA, write_room

EXACT = json.dumps({"depth_noise": "none"})
BOXES = {  # label -> box, mounting type
    "cabinet": (UprightBox([3.7, -0.8, 0.4], [0.6, 0.8, 0.8], 0.0), 3),
    "microwave": (UprightBox([3.8, -0.8, 0.95], [0.35, 0.45, 0.3], 0.0), 3),
    "wall cabinet": (UprightBox([3.82, 0.5, 1.5], [0.36, 0.6, 0.6], 0.0), 1),
    "box": (UprightBox([2.4, 0.5, 0.25], [0.5, 0.5, 0.5], 0.5), 2),
    "mug": (UprightBox([2.4, 0.5, 0.57], [0.14, 0.14, 0.14], 0.0), 2),
    "picture": (UprightBox([3.97, -0.1, 1.5], [0.06, 0.5, 0.4], 0.0), 1),
}


def _extract(folder: Path, out: Path, options: str = EXACT) -> Objects:
    run(input=folder, scene="test", out=out / "objects.json", options=options)
    return read_json(Objects, out / "objects.json")


def _write(folder: Path, names: list[str], **changes: bool) -> Path:
    return write_room(folder, [BOXES[name][0] for name in names], names, **changes)


@pytest.fixture(scope="module")
def furnished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Objects]:
    folder = tmp_path_factory.mktemp("room")
    return folder, _extract(_write(folder / "input", list(BOXES)), folder / "out")


def test_floor_and_wall_are_found(furnished: tuple[Path, Objects]) -> None:
    floor_from_world = np.array(furnished[1].floor_from_camera) @ invert_transform(WORLD_FROM_CAMERA)
    np.testing.assert_allclose(floor_from_world[2], [0, 0, 1, 0], atol=1e-3)
    np.testing.assert_allclose(floor_from_world[:2, 3], 0, atol=1e-3)  # the origin is below the camera
    view = floor_from_world[:3, :3] @ WORLD_FROM_CAMERA[:3, 2]
    assert view[0] > 0 and abs(view[1]) < 1e-6  # x runs along the view
    (wall,) = furnished[1].walls
    np.testing.assert_allclose(floor_from_world[:3, :3].T @ wall.normal, [-1, 0, 0], atol=2e-3)
    assert wall.offset == pytest.approx(-BACK_WALL, abs=5e-3)


@pytest.mark.parametrize("name", BOXES)
def test_boxes_and_mounting(furnished: tuple[Path, Objects], name: str) -> None:
    objects = furnished[1]
    floor_from_world = np.array(objects.floor_from_camera) @ invert_transform(WORLD_FROM_CAMERA)
    item = next(item for item in objects.objects if item.label == name)
    true, mounting = BOXES[name]
    assert item.box is not None and item.mounting is not None
    assert item.mounting.type == mounting
    assert item.mounting.walls == (["wall_1"] if mounting != 2 else [])
    assert item.box.center[2] - item.box.size[2] / 2 == pytest.approx(true.bottom, abs=0.03)
    if mounting == 2:  # seen from two sides and above: the whole box is there
        here = UprightBox(
            transform_points(floor_from_world, true.center),
            true.size,
            true.yaw + yaw_of_matrix(floor_from_world[:3, :3]),
        )
        box = UprightBox(item.box.center, item.box.size, item.box.yaw)
        assert oriented_iou(box, here) > (0.8 if name == "box" else 0.55)
        assert abs(wrap_angle(box.yaw - here.yaw, np.pi / 2)) < np.deg2rad(2)


def test_ids_files_and_annotations(furnished: tuple[Path, Objects]) -> None:
    folder, objects = furnished
    assert [item.id for item in objects.objects] == [name.replace(" ", "_") + "_1" for name in BOXES]
    masks = cv2.imread(str(folder / "out" / "masks.png"), cv2.IMREAD_UNCHANGED)
    assert masks.dtype == np.uint16 and masks.shape == (objects.height, objects.width)
    clouds = np.load(folder / "out" / "clouds.npz")
    depth = np.load(folder / "out" / "depth.npz")["depth"]
    assert depth.dtype == np.float32
    for item in objects.objects:
        assert item.pixels is not None
        assert (masks == item.mask).any() and clouds[item.id].shape == (item.points, 3)
        assert clouds[item.id].dtype == np.float32
        rows, columns = np.nonzero(masks == item.mask)
        assert item.pixels == (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)


@needs("pictures")
def test_what_was_found_is_drawn(furnished: tuple[Path, Objects]) -> None:
    folder, _ = furnished
    files = {"objects": folder / "out/objects.json", "image": folder / "input/rgb.png"}
    load_command("pictures", "objects")(**files, out=folder / "overview.png")
    assert (folder / "overview.png").stat().st_size > 10_000


def test_options_beside_the_picture_hold_where_the_run_has_the_default(tmp_path: Path) -> None:
    own = tmp_path / "config.yaml"
    own.write_text("experiment: {rooms: [mine]}\nextraction: {crop: 1.0, trim: 0.005}\n")
    found = merge_own_options(ExtractionConfig(trim=0.02, depth_noise="none"), own)
    assert (found.crop, found.trim, found.depth_noise) == (1.0, 0.02, "none")
    own.write_text("experiment: {rooms: [mine]}\n")
    assert merge_own_options(ExtractionConfig(), own) == ExtractionConfig()
    for text in ("extraction: {crop: 2}", "extraction: 3", "- 1", "a: ["):
        own.write_text(text)
        with refused("E-CONFIG-FILE"):
            merge_own_options(ExtractionConfig(), own)


def test_same_seed_same_bytes(furnished: tuple[Path, Objects], tmp_path: Path) -> None:
    def digests(out: Path, seed: int) -> list[str]:
        run(input=furnished[0] / "input", scene="test", out=out / "objects.json", seed=seed)
        return [hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(out.iterdir())]

    first = digests(tmp_path / "a", 3)
    assert first == digests(tmp_path / "b", 3)
    assert first != digests(tmp_path / "c", 4)
    assert read_json(Objects, tmp_path / "a/objects.json").digest == digest_of(furnished[0] / "input/rgb.png")


def test_noise_shifts_boxes_but_keeps_mounting(furnished: tuple[Path, Objects], tmp_path: Path) -> None:
    noisy = _extract(furnished[0] / "input", tmp_path, "{}")
    for exact, item in zip(furnished[1].objects, noisy.objects, strict=True):
        assert exact.box is not None and item.box is not None and item.mounting is not None
        assert 1e-3 < np.linalg.norm(np.subtract(exact.box.center, item.box.center)) < 0.25
        assert item.mounting.type == BOXES[item.label][1]


def test_measured_depth_is_not_disturbed(furnished: tuple[Path, Objects], tmp_path: Path) -> None:
    folder = shutil.copytree(furnished[0] / "input", tmp_path / "in")
    depth = np.load(folder / "depth.npz")["depth"]
    np.savez(folder / "depth.npz", depth=depth)  # no flag `exact`
    _extract(folder, tmp_path / "out", "{}")
    np.testing.assert_array_equal(np.load(tmp_path / "out" / "depth.npz")["depth"], depth)


def test_no_floor_mask_and_no_wall(tmp_path: Path) -> None:
    objects = _extract(_write(tmp_path / "in", ["box", "mug"], wall=False, floor=False), tmp_path / "out")
    np.testing.assert_allclose(
        (np.array(objects.floor_from_camera) @ invert_transform(WORLD_FROM_CAMERA))[2], [0, 0, 1, 0], atol=0.01
    )
    assert objects.walls == []
    assert [item.mounting.type for item in objects.objects if item.mounting] == [2, 2]


def test_a_wall_that_nobody_named_counts(furnished: tuple[Path, Objects], tmp_path: Path) -> None:
    folder = shutil.copytree(furnished[0] / "input", tmp_path / "in")
    given = json.loads((folder / "annotations.json").read_text())
    (folder / "annotations.json").write_text(json.dumps(given | {"walls": []}))
    found = _extract(folder, tmp_path / "out")
    assert found.walls[0].offset == pytest.approx(furnished[1].walls[0].offset, abs=0.01)
    assert [item.mounting for item in found.objects] == [item.mounting for item in furnished[1].objects]


def test_hidden_feet_are_extended_to_the_floor(tmp_path: Path) -> None:
    """A box in front hides the lower half of a cabinet: it stands all the same."""
    boxes = [UprightBox([2.2, 0, 0.3], [0.4, 1.6, 0.6], 0.0), UprightBox([3.0, 0, 0.6], [0.5, 0.6, 1.2], 0.0)]
    objects = _extract(write_room(tmp_path / "in", boxes, ["bench", "cabinet"]), tmp_path / "out")
    cabinet = objects.objects[1]
    clouds = np.load(tmp_path / "out" / "clouds.npz")
    assert clouds["cabinet_1"][:, 2].min() > 0.3
    assert cabinet.box is not None and cabinet.mounting is not None
    assert cabinet.box.center[2] - cabinet.box.size[2] / 2 == pytest.approx(0, abs=1e-6)
    assert cabinet.mounting.type == 2  # the bench in front does not change that the space behind is seen


def test_what_hides_the_space_beneath_does_not_make_a_cabinet_hang(tmp_path: Path) -> None:
    """A cabinet at the wall whose lower part a bench hides: nobody has seen that the space beneath is empty."""
    bench, cabinet = UprightBox([2.6, 0, 0.3], [0.4, 1.8, 0.6], 0.0), UprightBox([3.7, 0, 0.7], [0.6, 0.7, 1.4], 0.0)
    behind = _extract(write_room(tmp_path / "in", [bench, cabinet], ["bench", "cabinet"]), tmp_path / "out").objects[1]
    hung = replace(cabinet, center=[3.7, 0, 1.1], size=[0.6, 0.7, 0.6])
    alone = _extract(write_room(tmp_path / "in2", [hung], ["cabinet"]), tmp_path / "out2").objects[0]
    assert behind.mounting is not None and alone.mounting is not None
    assert (behind.mounting.type, alone.mounting.type) == (3, 1)
    assert behind.box is not None and behind.box.center[2] - behind.box.size[2] / 2 == pytest.approx(0, abs=1e-6)


def test_objects_that_cannot_be_used_fail_alone(tmp_path: Path) -> None:
    boxes = [
        UprightBox([2.5, 0, 0.3], [0.5, 0.5, 0.6], 0.0),
        UprightBox([2.2, 1.85, 0.3], [0.3, 0.6, 0.6], 0.0),  # at the left border, mostly outside the central 90 %
        UprightBox([3.5, 0, 0.1], [0.1, 0.1, 0.1], 0.0),  # behind the first one
    ]
    objects = _extract(write_room(tmp_path / "in", boxes, ["box", "chair", "mug"]), tmp_path / "out")
    assert [item.status for item in objects.objects] == ["ok", "failed", "failed"]
    assert "crop" in objects.objects[1].reason
    assert "not in the picture" in objects.objects[2].reason
    assert objects.objects[1].box is None and list(np.load(tmp_path / "out" / "clouds.npz")) == ["box_1"]


@pytest.mark.parametrize(("depth", "code"), [(b"depth", "E-FILE-UNREADABLE"), (None, "E-DEPTH-EMPTY")])
def test_bad_input_is_named_and_leaves_nothing(tmp_path: Path, depth: bytes | None, code: str) -> None:
    file = _write(tmp_path / "in", ["box"]) / "depth.npz"
    if depth:
        file.write_bytes(depth)
    else:
        np.savez(file, depth=np.zeros((360, 480), np.float32))
    with refused(code, "depth.npz"):
        _extract(file.parent, tmp_path / "out")
    assert not (tmp_path / "out").exists() or list((tmp_path / "out").iterdir()) == []


def _with_depth(folder: Path, name: str, depth: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Path:
    """A room with one object, on whose pixels the depth is a function of row and column."""
    _write(folder, [name])
    image = read_folder(folder)
    rows, columns = np.mgrid[: image.depth.shape[0], : image.depth.shape[1]]
    changed = np.where(image.masks == OBJECT, depth(rows, columns), image.depth).astype(np.float32)
    np.savez(folder / "depth.npz", depth=changed, exact=True)
    return folder


def test_an_object_of_impossible_size_fails_alone(tmp_path: Path) -> None:
    folder = _with_depth(tmp_path / "in", "box", lambda rows, columns: 2 + (rows % 40) * 2.0)
    (item,) = _extract(folder, tmp_path / "out").objects
    assert item.status == "failed" and "m large: its depth cannot be right" in item.reason
    assert check_contract(["objects", str(tmp_path / "out/objects.json")]) == 0


def test_a_box_has_some_depth_where_its_cloud_has_none(tmp_path: Path) -> None:
    """A sheet that the camera sees edge-on in space: its cloud is a plane, which is no box to place a model in."""
    normal = WORLD_FROM_CAMERA[0, :3]  # the sheet is the plane x = 2.5 of the world
    inverse_k = np.linalg.inv(INTRINSICS)

    def sheet(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        rays = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ inverse_k.T
        return 2.5 / (rays @ normal)

    (item,) = _extract(_with_depth(tmp_path / "in", "box", sheet), tmp_path / "out").objects
    assert item.box is not None and 0.001 <= min(item.box.size) < 0.003


def test_what_the_input_says_of_mounting_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = ["cabinet", "wall cabinet", "box", "picture", "mug"]
    folder = _write(tmp_path / "input", names)
    said = [(2, []), (3, [WALL]), (1, [WALL]), (3, [WALL]), (3, [77])]  # the box stands 1.4 m before the wall
    given = json.loads((folder / "annotations.json").read_text())
    given["walls"].append(77)  # no pixel shows it: no plane
    for item, (kind, walls) in zip(given["objects"], said, strict=True):
        item["mounting"] = {"type": kind, "walls": walls}
    (folder / "annotations.json").write_text(json.dumps(given))
    found = {item.label: item for item in _extract(folder, tmp_path / "out").objects}
    types = {label: (item.mounting.type, item.mounting.walls) for label, item in found.items() if item.mounting}
    assert types["cabinet"] == (2, []) and types["wall cabinet"] == types["picture"] == (3, ["wall_1"])
    measured = found["cabinet"].measured_mounting, found["wall cabinet"].measured_mounting
    assert measured == (Mounting(type=3, walls=["wall_1"]), Mounting(type=1, walls=["wall_1"]))
    stands = found["wall cabinet"].box
    assert stands is not None and stands.center[2] == pytest.approx(stands.size[2] / 2, abs=0.02)  # down to the floor
    assert types["box"] == types["mug"] == (2, []) and found["box"].measured_mounting is None
    assert "m behind it" in found["box"].note and found["mug"].note.startswith("no wall is found in mask 77")
    said_lines = capsys.readouterr().out.splitlines()
    assert len([line for line in said_lines if line.endswith(": mounting by geometry")]) == 2
