"""The rooms as a data set, our own scenes as submissions, a method that uses none of our code. Nothing is rendered."""

import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pandas as pd
import pytest
import trimesh

from benchmarks.open_rooms import packs, publish, rooms, submit
from roomkin.plugins.scorecard import reading, score
from roomkin.plugins.scorecard.tests.rooms import CABINET, POSE, TABLE, TRUTH
from roomkin.plugins.scorecard.truth import as_plain, read_truth
from roomkin.stages.contracts import write_json
from roomkin.stages.geometry.boxes import UprightBox, distances_along
from tests.refusals import refused
from tests.unit.contract_files import write_files

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.filterwarnings("ignore")


def write_pictures(root: Path) -> Path:
    """A rendered room, as `pictures` leaves it."""
    folder = root / "pictures" / TRUTH.name
    folder.mkdir(parents=True)
    truth = replace(TRUTH, half="work", things=[replace(TABLE, yaw=0.1 + 0.2)])
    write_json(folder / "room.json", as_plain(truth))
    for name in publish.FILES:
        (folder / name).write_text(name)
    (root / "packs/archives").mkdir(parents=True)
    with zipfile.ZipFile(root / "packs/archives/chairs-1.0-py3-none-any.whl", "w") as file:
        file.writestr("chairs-1.0.dist-info/licenses/LICENSE", "MIT")
        file.writestr("chairs/data.txt", "no licence")
    return folder


def model(name: str) -> Any:
    """A model of one part, a box."""
    box = trimesh.creation.box((1, 1, 1))
    part = packs.PaintedMesh(np.asarray(box.vertices), np.asarray(box.faces), None, None, (0, 0, 0), None, 1.0)
    return SimpleNamespace(id=name, parts=[part], opens=("left", "slide"), handle="knob", pack="bullet")


@pytest.fixture
def one_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publish.packs, "models", lambda folder, half: [model("m_table")])


@pytest.mark.usefixtures("one_model")
def test_the_rooms_become_plain_files_with_a_manifest(tmp_path: Path) -> None:
    write_pictures(tmp_path)
    publish.publish(tmp_path, ["work"])
    data = tmp_path / "rooms"
    truth = read_truth(data / "work/toy_room_1/truth.json")
    assert truth.things[0].yaw == 0.3 and (truth.things[0].opens, truth.things[0].handle) == (("left", "slide"), "knob")
    assert score.read_shapes(data / "work/shapes.npz")["m_table"].all()
    assert (data / "licences/chairs-LICENSE").read_text() == "MIT" and "[toy_room_1]" in (
        data / "work/README.md"
    ).read_text()
    manifest = json.loads((data / "manifest.json").read_text())
    agreed, pixels = manifest["agreed"].keys(), manifest["may_differ"].keys()
    assert {"work/toy_room_1/truth.json", "work/toy_room_1/camera.json", "licences/chairs-LICENSE"} <= agreed
    assert {"work/toy_room_1/rgb.png", "work/toy_room_1/depth_phone.png", "work/shapes.npz"} <= pixels
    first = {path: path.read_bytes() for path in data.rglob("*") if path.is_file()}
    publish.publish(tmp_path, ["work"])
    assert first == {path: path.read_bytes() for path in data.rglob("*") if path.is_file()}


@pytest.mark.usefixtures("one_model")
def test_what_differs_from_another_machine_is_told(tmp_path: Path) -> None:
    folder = write_pictures(tmp_path)
    publish.publish(tmp_path, ["work"])
    kept = tmp_path / "kept.json"
    kept.write_bytes((tmp_path / "rooms/manifest.json").read_bytes())
    assert publish.compare_manifests(kept, tmp_path / "rooms/manifest.json") == []
    (folder / "rgb.png").write_text("another")
    (folder / "intrinsics.json").write_text("another")
    publish.publish(tmp_path, ["work"])
    assert publish.compare_manifests(kept, tmp_path / "rooms/manifest.json") == [
        "work/toy_room_1/camera.json: differs",
        "work/toy_room_1/rgb.png: differs in pixels, by which nothing is scored",
    ]


@pytest.mark.usefixtures("one_model")
def test_a_picture_without_the_depth_of_three_sensors_is_told(tmp_path: Path) -> None:
    (write_pictures(tmp_path) / "depth_phone.png").unlink()
    with refused("E-FILE-MISSING", "has no depth_phone.png. Fix: delete it and render it again"):
        publish.publish(tmp_path, ["work"])


class Folders(dict[str, Path]):
    """A library of one cabinet with a door."""

    def asset(self, name: str) -> Any:
        return SimpleNamespace(joints=[SimpleNamespace(panel=SimpleNamespace(hinge="left"))])


def test_our_scenes_are_a_submission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    valid = write_files(tmp_path / "valid")
    monkeypatch.setattr(submit, "AssetFolders", lambda path: Folders())
    folder = write_pictures(tmp_path)
    for kind in ("drawn", "unaided"):
        made = tmp_path / "results" / kind / folder.name
        for place, name in (("geometry", "generation/scene_1.json"), ("extraction", "extraction/objects.json")):
            (made / place).mkdir(parents=True)
            (made / place / Path(name).name).write_bytes((valid / name).read_bytes())
        submit.submit(tmp_path, tmp_path, "work", kind, tmp_path / f"{kind}.json", "abc1234")
    told, alone = (reading.read_submission(tmp_path / f"{kind}.json", [folder.name]) for kind in ("drawn", "unaided"))
    assert not told.unread and not alone.unread and "abc1234" in told.about.code
    (first, *_), (other, *_) = told.rooms[folder.name].room.things, alone.rooms[folder.name].room.things
    assert first.number is not None and other.number is None and first.opens == ["left"]
    again = tmp_path / "folder" / folder.name
    again.mkdir(parents=True)
    (again.parent / "method.json").write_text(json.dumps(told.about.model_dump(mode="json")))
    for name in ("generation/scene_1.json", "extraction/objects.json"):
        (again / Path(name).name).write_bytes((valid / name).read_bytes())
    read = reading.read_submission(again.parent, [folder.name]).rooms[folder.name].room.things
    assert [(one.name, one.number, one.support) for one in read] == [
        (one.name, one.number, one.support) for one in told.rooms[folder.name].room.things
    ]


def test_boxes_are_found_in_depth_alone(tmp_path: Path) -> None:
    """A cabinet on the floor before a wall, in clean depth."""
    rays = np.stack(
        [*np.meshgrid((np.arange(640) - 319.5) / 500, (np.arange(480) - 239.5) / 500), np.ones((480, 640))], -1
    )
    world = rays @ POSE[:3, :3].T
    with np.errstate(divide="ignore"):
        depth = np.minimum(np.where(world[..., 2] < 0, -1.4 / world[..., 2], 9), 3.7 / world[..., 1])  # floor, wall
    box = UprightBox((1.6, 3.2, 0.45), (0.5, 0.8, 0.9), -np.pi / 2)
    depth = np.minimum(depth, distances_along(POSE[:3, 3], world, box))
    folder = tmp_path / "rooms/toy/toy_room_1"
    folder.mkdir(parents=True)
    cv2.imwrite(str(folder / "depth_stereo.png"), np.rint(1000 * depth).astype(np.uint16))
    write_json(folder / "camera.json", {"fx": 500.0, "fy": 500.0, "cx": 319.5, "cy": 239.5})
    truth = replace(TRUTH, things=[replace(CABINET, position=(1.6, 3.2, 0.45), size=(0.5, 0.8, 0.9), yaw=-np.pi / 2)])
    write_json(folder / "truth.json", as_plain(truth))
    script = ROOT / "benchmarks/boxes_from_depth.py"
    assert "roomkin" not in script.read_text() and "stages" not in script.read_text()
    for out in ("a.json", "b.json"):
        subprocess.run([sys.executable, script, tmp_path / "rooms/toy", tmp_path / out], check=True)
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    score.run(tmp_path / "a.json", rooms="toy", data=tmp_path / "rooms", out=tmp_path / "out", pictures=False)
    (row,) = pd.read_csv(tmp_path / "out/things.csv").to_dict("records")
    assert row["placed"] and row["facing"] and row["carrier"], row
    assert max(abs(row["off_width_cm"]), abs(row["off_height_cm"])) < 3, row  # little of its top shows


@pytest.mark.parametrize("path", sorted((ROOT / "docs/results/scorecard").glob("*_*.json")), ids=lambda path: path.stem)
def test_submissions_in_the_repository_are_whole_small_and_of_rooms_that_there_are(path: Path) -> None:
    document = json.loads(path.read_text(encoding="utf-8"))
    half = path.stem.partition("_")[0]
    read = reading.read_submission(path, document["rooms"])
    assert read.unread == {} and set(document["rooms"]) <= set(rooms.names(half)) and path.stat().st_size < 1_000_000


def test_the_manifest_names_every_room_of_the_sets_that_were_made() -> None:
    manifest = json.loads((ROOT / "docs/results/scorecard/manifest.json").read_text(encoding="utf-8"))
    truths = {Path(name).parent.name for name in manifest["agreed"] if name.endswith("truth.json")}
    assert truths == {name for half in packs.HALVES | packs.MIXED for name in rooms.names(half)} and len(truths) == 87
