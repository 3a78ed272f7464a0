"""Files of pictures that nothing can read are refused before any job runs."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.config.inputs import INPUT_FILES
from roomkin.stages.perception.read.early import check_pictures
from tests.refusals import refused
from tests.workflow.workspace import dry_run, make, put

FRAME = {"image": "color.png", "depth": "depth.png", "camera": "k.json", "masks": "masks.png", "labels": "labels.json"}
RECORDING = [f"hall/{kind}/{number}.png" for kind in ("color", "depth") for number in range(2)]


def check(given: dict[str, Any]) -> None:
    check_pictures(ExperimentConfig.model_validate({"rooms": ["mine"], "inputs": {"mine": given}}))


@pytest.fixture(autouse=True)
def files(own_folder: None) -> None:
    put(*map(Path, [*FRAME.values(), "hall/intrinsics.json", *RECORDING]))
    put(*(Path("room", name) for name in INPUT_FILES))


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def write(text: str) -> Callable[[Path], None]:
    return lambda path: path.write_text(text) and None


@pytest.mark.parametrize(
    ("given", "broken", "damage", "code"),
    [
        ({"image": "color.png"}, "color.png", write("a note"), "E-IMAGE-UNREADABLE"),
        ({"image": "color.png"}, "color.png", write("    ftypheic"), "E-LIBRARY-MISSING"),
        (FRAME, "color.png", write("a note"), "E-IMAGE-UNREADABLE"),
        (FRAME, "depth.png", cut, "E-FILE-UNREADABLE"),
        (FRAME, "k.json", write('{"fx": '), "E-FILE-UNREADABLE"),
        (FRAME, "k.json", write('{"fx": 60, "fy": -60, "cx": 32, "cy": 24}'), "E-CAMERA-INTRINSICS"),
        (FRAME, "masks.png", write("a note"), "E-IMAGE-UNREADABLE"),
        (FRAME, "labels.json", write("[]"), "E-MASKS-NAMES"),
        ({"recording": "hall", "number": 1}, "hall/depth/1.png", cut, "E-FILE-UNREADABLE"),
        ({"recording": "hall", "number": 1}, "hall/intrinsics.json", write("{}"), "E-CAMERA-INTRINSICS"),
        ({"recording": "hall", "number": 1}, "hall/color/1.png", Path.unlink, "E-RECORDING-FRAME"),
        ({"folder": "room"}, "room/rgb.png", write("a note"), "E-IMAGE-UNREADABLE"),
        ({"folder": "room"}, "room/masks.png", write("a note"), "E-IMAGE-UNREADABLE"),
        ({"folder": "room"}, "room/depth.npz", cut, "E-FILE-UNREADABLE"),
        ({"folder": "room"}, "room/camera.json", write("a note"), "E-CONTRACT-BROKEN"),
        ({"folder": "room"}, "room/annotations.json", write("a note"), "E-CONTRACT-BROKEN"),
    ],
)
def test_what_nothing_can_read_is_refused(
    given: dict[str, Any], broken: str, damage: Callable[[Path], None], code: str, capsys: pytest.CaptureFixture[str]
) -> None:
    check(given)
    damage(Path(broken))
    with refused(code) as caught:
        check(given)
    assert Path(broken).name in str(caught.value) or code == "E-RECORDING-FRAME"
    assert capsys.readouterr().out == "", "the jobs say what they make of a file"


def test_a_drawing_that_is_none_is_refused() -> None:
    with refused("E-CONTRACT-VERSION", "k.json"):
        check({"image": "color.png", "drawing": "k.json"})


def test_the_camera_may_be_told_without_a_file() -> None:
    for camera in ({"camera": "xtion"}, {"fov": 60}, {"fx": 60, "fy": 60, "cx": 32, "cy": 24}):
        check({"image": "color.png", "depth": "depth.png", **camera})


def test_a_picture_that_is_in_no_run_is_not_looked_at() -> None:
    Path("color.png").write_text("a note")
    check_pictures(ExperimentConfig.model_validate({"rooms": ["room_1"], "inputs": {"mine": {"image": "color.png"}}}))


def test_a_workflow_says_it_in_its_last_line(tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    put(folder / "color.png", folder / "depth.png")
    (folder / "k.json").write_text(json.dumps({"fx": 60})[:-1])
    done = dry_run(folder, "photo", "--config", "image=color.png", "depth=depth.png", "camera=k.json")
    assert done.returncode == 1 and done.stdout.splitlines()[-1].startswith("error: k.json: is no readable"), (
        done.stdout
    )
