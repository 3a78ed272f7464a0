"""Dry runs: two pictures are never one scene, whatever their files are called."""

import json
import os
from hashlib import sha256
from pathlib import Path

import pytest

from roomkin.stages.config.inputs import INPUT_FILES, scene_of
from tests.workflow.workspace import dry_run, make, planned, put

FRAME = ("depth=depth.png", "camera=k.json")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = make(tmp_path / "run")
    put(folder / "depth.png", folder / "k.json")
    return folder


def hold(folder: Path, path: str, picture: str) -> None:
    """A result of a picture."""
    (folder / path).parent.mkdir(parents=True, exist_ok=True)
    (folder / path).write_text(json.dumps({"digest": sha256((folder / picture).read_bytes()).hexdigest()}))


@pytest.mark.parametrize(
    "stem", ["厨房", "кухня", "रसोई", "مطبخ", "IMG_1", "IMG 1", "IMG (1)", "😀", "a,b", "it's", "a[1]*"]
)
def test_a_picture_of_any_name_is_planned_as_a_scene_of_its_own(folder: Path, stem: str) -> None:
    put(folder / f"{stem}.png")
    done = dry_run(folder, "photo", "--config", f"image={stem}.png", *FRAME)
    assert done.returncode == 0 and planned(done.stdout)["scene_page"] == planned(done.stdout)["see"] == 1, done.stdout
    scene = scene_of(Path(stem))
    for path in (f"results/scenes/{scene}/view/rgb.png", f"results/report/scenes/{scene}.html"):
        assert path in done.stdout, done.stdout


def test_scenes_of_many_scripts_stand_side_by_side(folder: Path) -> None:
    names = ("厨房", "кухня", "nhà_bếp", "a", "A")
    put(*(folder / "own" / name / file for name in names for file in INPUT_FILES))
    (folder / "mine.yaml").write_text("experiment: {inputs: [own], rooms: ['*'], targets: {door: null}}")
    done = dry_run(folder, "pages", "--configfile", "mine.yaml")
    assert planned(done.stdout)["extract"] == planned(done.stdout)["scene_page"] == len(names), done.stdout
    assert all(f"results/generation/default/{name}/scene_1.json" in done.stdout for name in names)


@pytest.mark.parametrize("name", ["{x}.png", "-x.png", "pipe.png"])
def test_a_file_that_no_rule_can_read_is_refused_in_a_line(folder: Path, name: str) -> None:
    if name == "pipe.png":
        os.mkfifo(folder / name)
    else:
        put(folder / name)
    done = dry_run(folder, "photo", "--config", f"image={name}", *FRAME)
    (line,) = [line for line in done.stdout.splitlines() if "error" in line.lower()]
    assert line.startswith(f"error: config: image: {name} ") and ". Fix: " in line and done.returncode == 1, done.stdout


HELD = "results/scenes/kitchen/view/camera.json"
ONE = "{image: b/kitchen.png, depth: depth.png, camera: k.json}"


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("image", ("photo", "--config", "image=b/kitchen.png", *FRAME)),
        ("experiment.inputs.kitchen", ("pages", "--configfile", "mapping.yaml")),
        ("mine.csv, row 2", ("pages", "--configfile", "table.yaml")),
        ("experiment.inputs.kitchen", ("pages", "--configfile", "folder.yaml")),
    ],
)
def test_another_picture_under_a_scene_s_name_is_refused(folder: Path, key: str, words: tuple[str, ...]) -> None:
    put(folder / "a/kitchen.png", folder / "b/kitchen.png", *(folder / "own/kitchen" / file for file in INPUT_FILES))
    (folder / "mine.csv").write_text("scene,image,depth,camera\nkitchen,b/kitchen.png,depth.png,k.json\n")
    for name, inputs in (("mapping", f"{{kitchen: {ONE}}}"), ("table", "mine.csv"), ("folder", "own")):
        text = f"experiment: {{inputs: {inputs}, rooms: ['*'], targets: {{door: null}}}}"
        (folder / f"{name}.yaml").write_text(text)
    hold(folder, HELD, "a/kitchen.png")
    done = dry_run(folder, *words)
    told = (
        f"error: config: {key}: results/ holds another picture under this name: see {HELD}. Fix: call the file or the "
    )
    assert done.returncode == 1 and told in done.stdout and "Traceback" not in done.stdout, done.stdout
    hold(folder, HELD, "own/kitchen/rgb.png" if "folder.yaml" in words else "b/kitchen.png")
    done = dry_run(folder, *words)
    assert done.returncode == 0 and planned(done.stdout)["scene_page"] == 1, done.stdout
