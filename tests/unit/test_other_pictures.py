"""Results of another picture are neither replaced nor mixed: a scene's name is refused where they are."""

import json
import os
import re
import shutil
from hashlib import sha256
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from roomkin.stages.config import other_pictures, pictures
from roomkin.stages.config.inputs import INPUT_FILES
from roomkin.stages.config.model import Config, load
from tests.refusals import refused

HELD = (
    "results/scenes/kitchen/view/camera.json",
    "results/scenes/kitchen/frame/camera.json",
    "results/photo/kitchen/camera.json",
    "results/extraction/kitchen/objects.json",
)
OURS, THEIRS = b"our picture", b"their picture"
WORDS = "results/ holds another picture under this name: see "


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write("kitchen.png", OURS)
    write("depth.png", b"")


def write(path: str, data: bytes) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_bytes(data)


def hold(path: str, picture: bytes) -> None:
    """A result of a picture."""
    write(path, json.dumps({"version": 1, "digest": sha256(picture).hexdigest()}).encode())


def by_image() -> Config:
    return load({"image": "kitchen.png", "depth": "depth.png", "camera": "xtion"})


def by_inputs(inputs: Any) -> Config:
    return load({"experiment": {"rooms": ["*"], "inputs": inputs, "targets": {}}})


def by_mapping() -> Config:
    return by_inputs({"kitchen": {"image": "kitchen.png", "depth": "depth.png", "fov": 60}})


def by_table() -> Config:
    write("mine.csv", b"scene,image,depth,fov\nkitchen,kitchen.png,depth.png,60\n")
    return by_inputs("mine.csv")


def by_folder() -> Config:
    for name in INPUT_FILES:
        write(f"own/kitchen/{name}", OURS if name == "rgb.png" else b"")
    camera = {"version": 1, "width": 64, "height": 48, "intrinsics": [[60, 0, 32], [0, 60, 24], [0, 0, 1]]}
    write("own/kitchen/camera.json", json.dumps(camera).encode())
    return by_inputs("own")


def by_recording() -> Config:
    for k, data in enumerate((THEIRS, OURS)):
        write(f"rec/color/{k}.png", data)
        write(f"rec/depth/{k}.png", b"")
    return by_inputs({"kitchen": {"recording": "rec", "number": 1, "fov": 60}})


WAYS = {
    by_image: "image: ",
    by_mapping: "experiment.inputs.kitchen: ",
    by_table: "mine.csv, row 2: ",
    by_folder: "experiment.inputs.kitchen: ",
    by_recording: "experiment.inputs.kitchen: ",
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("held", HELD)
def test_results_of_another_picture_are_kept(way: Any, held: str) -> None:
    hold(held, THEIRS)
    with refused("E-CONFIG-CLASH", f"{WAYS[way]}{WORDS}{held}. Fix: call the file or the scene otherwise") as caught:
        way()
    (folder,) = re.findall(r"or delete (\S+)$", str(caught.value))
    shutil.rmtree(folder)  # the mend
    assert way().experiment.rooms == ["kitchen"]


@pytest.mark.parametrize("way", WAYS)
def test_the_same_picture_is_the_same_scene(way: Any) -> None:
    for held in HELD:
        hold(held, OURS)
    assert way().experiment.rooms == ["kitchen"]


def test_the_picture_that_was_there_is_shown_and_all_that_is_of_it_named() -> None:
    for held in HELD:
        hold(held, THEIRS)
    write("results/scenes/kitchen/view/rgb.png", b"")
    with refused("E-CONFIG-CLASH", f"{WORDS}results/scenes/kitchen/view/rgb.png. ") as caught:
        by_image()
    folders = " and ".join(f"results/{stage}/kitchen" for stage in ("scenes", "photo", "extraction"))
    assert str(caught.value).endswith(f"or delete {folders}")


@pytest.mark.parametrize(
    "said", [b"", b"{", b"[]", b"null", b"[" * 10**5, b'{"digest": 3}', b'{"digest": ""}', b"{}", b"\xff"]
)
def test_a_result_that_does_not_tell_is_let_through(said: bytes) -> None:
    for held in HELD:
        write(held, said)
    assert by_image().experiment.rooms == ["kitchen"]


@pytest.mark.parametrize("held", HELD)
def test_what_is_no_file_there_is_not_read(held: str) -> None:
    Path(held).parent.mkdir(parents=True)
    os.mkfifo(held)
    assert by_image().experiment.rooms == ["kitchen"]


def test_no_picture_is_read_where_there_is_nothing_to_compare_it_with(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(path: Path) -> str:
        raise AssertionError(path)

    monkeypatch.setattr(pictures, "digest_of_image", read)
    assert by_image().experiment.rooms == ["kitchen"]
    write(HELD[0], b"{}")
    assert by_image().experiment.rooms == ["kitchen"]
    hold(HELD[0].replace("kitchen", "bath"), THEIRS)
    assert by_image().experiment.rooms == ["kitchen"]
    hold(HELD[0], THEIRS)
    with pytest.raises(AssertionError):
        by_image()


def test_a_recording_is_listed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    by_recording()
    listed = []
    monkeypatch.setattr(other_pictures, "list_frames", lambda path: listed.append(path) or [(Path("kitchen.png"),) * 2])
    for k in (0, 1):
        hold(f"results/scenes/rec-{k}/view/camera.json", OURS)
    load({"image": "rec", "camera": "xtion"})
    assert listed == [Path("rec")]


@pytest.mark.parametrize("number", [1, 2])
def test_a_frame_that_is_a_device_or_not_there_is_left_to_the_rule_that_reads_it(number: int) -> None:
    by_recording()
    hold(HELD[0], THEIRS)
    Path("rec/color/1.png").unlink()
    Path("rec/color/1.png").symlink_to("/dev/null")
    by_inputs({"kitchen": {"recording": "rec", "number": number, "fov": 60}})


def test_a_folder_whose_files_cannot_be_used_is_left_to_who_says_so() -> None:
    by_folder()
    hold(HELD[3], THEIRS)
    Path("own/kitchen/rgb.png").rename("rgb.png")
    Path("own/kitchen/rgb.png").symlink_to("/dev/null")
    with refused("E-CONFIG-FILE", "own/kitchen has no rgb.png"):
        by_inputs("own")
    Path("rgb.png").replace("own/kitchen/rgb.png")
    write("own/kitchen/camera.json", b"{")
    assert by_inputs("own").experiment.rooms == ["kitchen"]


def test_a_picture_that_may_not_be_read_is_left_to_the_rule_that_reads_it(monkeypatch: pytest.MonkeyPatch) -> None:
    hold(HELD[0], THEIRS)
    monkeypatch.setattr(pictures, "digest_of_image", Mock(side_effect=PermissionError))
    assert by_image().experiment.rooms == ["kitchen"]


def test_only_scenes_of_this_run_are_looked_at() -> None:
    hold(HELD[0], THEIRS)
    one = {"image": "kitchen.png", "depth": "depth.png", "fov": 60}
    inputs = {"kitchen": one, "bath": one}
    assert load({"experiment": {"rooms": ["bath"], "inputs": inputs, "targets": {}}}).experiment.rooms == ["bath"]


def test_a_picture_that_is_not_there_is_told_once() -> None:
    hold(HELD[0], THEIRS)
    Path("kitchen.png").unlink()
    with refused("E-CONFIG-FILE", "no file kitchen.png") as caught:
        by_image()
    assert WORDS not in str(caught.value)
