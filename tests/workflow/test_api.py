"""`roomkin` gives what the workflow gives, byte for byte, and the lines of the pages run."""

import json
import os
import re
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
import yaml
from PIL import Image

import roomkin
from roomkin.stages.contracts import GeneratedScene, read_json
from tests.refusals import refused
from tests.workflow.workspace import ROOT

FENCE = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
SMALL = yaml.safe_load((ROOT / "config/test/micro.yaml").read_text(encoding="utf-8"))


def blocks(page: str) -> list[str]:
    return FENCE.findall((ROOT / page).read_text(encoding="utf-8"))


def run_lines(folder: Path, text: str) -> None:
    """Run lines of Python in a process of their own."""
    env = os.environ | {"PYTHONPATH": str(ROOT)}
    said = subprocess.run([sys.executable, "-c", text], cwd=folder, env=env, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr[-3000:]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A library, a room and its scenes, by the config of the micro run."""
    folder = tmp_path_factory.mktemp("made")
    run_lines(
        folder,
        f"""
from roomkin import make_library, make_room, make_scenes
library = make_library("library", {SMALL!r})
picture = make_room("room_1", library, "rooms", {SMALL!r})
make_scenes(picture, library, "scenes", {SMALL!r})
""",
    )
    assert sorted(path.name for path in (folder / "scenes").glob("scene_?.json")) == ["scene_1.json", "scene_2.json"]
    return folder


PAIRS = {
    "library": "assets/library",
    "library/snapshots": "assets/snapshots",
    "rooms/room_1/input": "scenes/room_1/input",
    "scenes": ("extraction/room_1", "matching/default/room_1", "generation/default/room_1"),
}


@pytest.mark.parametrize("ours", [*PAIRS, "library/features"])
def test_the_same_config_gives_the_same_bytes(run: Path, made: Path, ours: str) -> None:
    theirs = PAIRS.get(ours) or f"matching/features/{next((made / ours).iterdir()).name}"
    folders = [run / "results" / each for each in ([theirs] if isinstance(theirs, str) else theirs)]
    here = made / ours if ours != "library/features" else next((made / ours).iterdir())
    files = [path for path in here.iterdir() if path.is_file()]
    assert len(files) > 3
    for path in files:
        (known,) = [folder / path.name for folder in folders if (folder / path.name).is_file()]
        assert path.read_bytes() == known.read_bytes(), path.name


def test_a_picture_of_yours_comes_out_in_its_colors_and_is_the_same_otherwise(made: Path, tmp_path: Path) -> None:
    shutil.copytree(made / "rooms/room_1/input", tmp_path / "room_1")
    library = str(made / "library/library.json")
    run_lines(tmp_path, f"from roomkin import make_scenes\nmake_scenes('room_1', {library!r}, 'scenes', {SMALL!r})")
    for path in sorted((tmp_path / "scenes").glob("scene_?.json")):
        ours, theirs = (read_json(GeneratedScene, folder / path.name) for folder in (path.parent, made / "scenes"))
        assert any(each.finish for each in ours.objects) and not any(each.finish for each in theirs.objects)
        plain = [each.model_copy(update={"finish": {}}) for each in ours.objects]
        assert ours.model_copy(update={"objects": plain, "made": theirs.made}) == theirs


def test_twelve_lines_load_a_policy_and_film_it(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text, _ = blocks("docs/load-policy.md")
    assert len([line for line in text.splitlines() if line and "import " not in line]) <= 12
    policy = tmp_path / "results/training/door/lite/cousins_4/lite/seed_0"
    shutil.copytree(next((run / "results/training/door/micro/twin").iterdir()) / "seed_0", policy)
    config = json.loads((policy / "config.json").read_text())
    config["task_options"]["max_steps"] = 12
    (policy / "config.json").write_text(json.dumps(config))
    (tmp_path / "results/assets").symlink_to(run / "results/assets")
    monkeypatch.chdir(tmp_path)
    said: dict[str, Any] = {}
    exec(text, said)
    assert said["env"].observation_space.contains({name: seen.numpy() for name, seen in said["observation"].items()})
    with Image.open(tmp_path / "film.webp") as film:
        assert film.n_frames > 10 and film.size == (480, 360)  # type: ignore[attr-defined]


@pytest.mark.parametrize("page", ["docs/load-policy.md", "README.md"])
def test_the_lines_of_a_page_make_scenes(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str
) -> None:
    texts = [text for text in blocks(page) if "make_scenes" in text]
    if page == "README.md" and not texts:
        pytest.skip("it shows none")
    (tmp_path / "kitchen").symlink_to(made / "rooms/room_1/input")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(roomkin, "make_library", lambda out: made / "library/library.json")
    monkeypatch.setattr(roomkin, "make_room", partial(roomkin.make_room, config=SMALL))
    monkeypatch.setattr(roomkin, "make_scenes", partial(roomkin.make_scenes, config=SMALL))
    exec(texts[0], {})
    assert (tmp_path / "scenes/scene_2.glb").is_file()
    assert json.loads((tmp_path / "scenes/scene_1.json").read_text())["scene"] in ("kitchen", "room_1")


def test_scenes_of_another_picture_are_not_replaced(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = made / "library/library.json"
    monkeypatch.setattr("roomkin.stages.extraction.extract.run", Mock(side_effect=InterruptedError))  # it begins
    for folder, noise in (("a/kitchen", 0), ("b/kitchen", 1)):
        shutil.copytree(made / "rooms/room_1/input", tmp_path / folder)
        with (tmp_path / folder / "rgb.png").open("ab") as picture:
            picture.write(bytes(noise))
    objects = tmp_path / "scenes/objects.json"
    shutil.copytree(made / "scenes", objects.parent)
    before = objects.read_bytes()
    with refused("E-PICTURE-OTHER", f"{objects}: is of another picture. Fix: choose another folder"):
        roomkin.make_scenes(tmp_path / "b/kitchen", library, tmp_path / "scenes", SMALL)
    assert objects.read_bytes() == before
    with pytest.raises(InterruptedError):  # the same picture
        roomkin.make_scenes(tmp_path / "a/kitchen", library, tmp_path / "scenes", SMALL)
    objects.write_text("{")
    with pytest.raises(InterruptedError):  # broken: made anew
        roomkin.make_scenes(tmp_path / "b/kitchen", library, tmp_path / "scenes", SMALL)
