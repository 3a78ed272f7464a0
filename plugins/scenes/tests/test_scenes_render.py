"""Rooms in the simulator: they stand still, and their photographs agree with the truth."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from roomkin.plugins.furniture.library import run as make_library
from roomkin.plugins.scenes.layout import cast
from roomkin.plugins.scenes.photograph import furnish
from roomkin.plugins.scenes.recipe import read_room, series
from roomkin.plugins.scenes.render import run
from roomkin.stages.contracts import Annotations, Camera, InputError, Truth, read_json
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.geometry.frames import back_project, transform_points, yaw_matrix
from roomkin.stages.simulation.loading import physics_scene
from tests.refusals import refused
from tests.unit.physics import add_ground, position_of

ROOMS = [read_room(path) for path in series()]
OPTIONS = json.dumps({"width": 400, "height": 300, "supersampling": 1})
MIN_PIXELS = 40  # per object at 400 x 300
SECONDS, DRIFT = 1.0, 0.01


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("library") / "library.json"
    make_library(out=path)
    return path


def test_every_room_stands_still(library: Path) -> None:
    folders = AssetFolders(library)
    models = {asset: folders.asset(asset) for asset in folders}
    for room in cast(ROOMS, models, 0, library).values():
        scene = physics_scene()
        add_ground(scene)
        bodies = furnish(scene, room, folders, fixed=False)
        start = {name: position_of(body) for name, body in bodies.items()}
        for _ in range(round(SECONDS / scene.timestep)):
            scene.step()
        for name, body in bodies.items():
            moved = np.linalg.norm(position_of(body) - start[name])
            assert moved < DRIFT, f"{room.room.name} {name} moved {100 * moved:.1f} cm"


@pytest.fixture(scope="module")
def photographed(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("room_1")
    run(library=(library,), scene="room_1", out=folder, options=OPTIONS)
    return folder


def test_photograph_agrees_with_the_truth(photographed: Path) -> None:
    camera = read_json(Camera, photographed / "input" / "camera.json")
    annotations = read_json(Annotations, photographed / "input" / "annotations.json")
    truth = read_json(Truth, photographed / "truth.json")
    masks = cv2.imread(str(photographed / "input" / "masks.png"), cv2.IMREAD_UNCHANGED)
    rgb = cv2.imread(str(photographed / "input" / "rgb.png"))
    depth = np.load(photographed / "input" / "depth.npz")["depth"]
    assert masks.dtype == np.uint16 and depth.dtype == np.float32
    assert rgb.shape == (camera.height, camera.width, 3) == (300, 400, 3) and rgb.std() > 20
    assert truth.scale == pytest.approx(ROOMS[0].scale, abs=0.01)
    assert [item.mask for item in annotations.objects] == [item.mask for item in truth.objects]

    points = transform_points(np.array(truth.world_from_camera), back_project(depth, camera.intrinsics))
    for item, said in zip(truth.objects, annotations.objects, strict=True):
        mask = masks == item.mask
        assert mask.sum() >= MIN_PIXELS, f"{said.label}: {mask.sum()} pixels"
        rows, columns = np.nonzero(mask)
        assert columns.min() >= 20 and columns.max() < 380 and rows.min() >= 15 and rows.max() < 285
        local = (points[mask] - item.position) @ yaw_matrix(item.yaw)
        assert (np.abs(local) < np.array(item.size) / 2 + 0.01).all(), f"{said.label} is not in its box"
    floor = points[masks == annotations.floor]
    assert np.abs(floor[:, 2]).max() < 0.01
    back = points[masks == annotations.walls[0]]
    assert np.abs(back[:, 0]).max() < 0.01


def test_a_recoloured_room_has_the_same_models_in_other_sizes(
    library: Path, photographed: Path, tmp_path: Path
) -> None:
    run(library=(library,), scene="room_1", out=tmp_path, options=OPTIONS, finish_seed=1)
    before, after = (read_json(Truth, folder / "truth.json") for folder in (photographed, tmp_path))
    for one, other in zip(before.objects, after.objects, strict=True):
        assert one.asset == other.asset
        ratio = np.divide(other.size, one.size)
        assert ratio.min() > 0.84 and ratio.max() < 1.16 and np.ptp(ratio) > 0.01
    hues = [cv2.imread(str(folder / "input/rgb.png")).mean(axis=(0, 1)) for folder in (photographed, tmp_path)]
    assert np.abs(hues[0] - hues[1]).max() > 3


def test_same_seed_same_bytes(library: Path, photographed: Path, tmp_path: Path) -> None:
    run(library=(library,), scene="room_1", out=tmp_path, options=OPTIONS)
    files = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    assert len(files) == 6
    for path in files:
        assert (tmp_path / path).read_bytes() == (photographed / path).read_bytes(), path


def test_an_unknown_room_is_named(library: Path, tmp_path: Path) -> None:
    with refused("E-ROOM-NAME", "room_9"):
        run(library=(library,), scene="room_9", out=tmp_path)
    with pytest.raises(InputError, match=r"nowhere\.json"):
        run(library=(tmp_path / "nowhere.json",), scene="room_1", out=tmp_path)
    assert list(tmp_path.iterdir()) == []
