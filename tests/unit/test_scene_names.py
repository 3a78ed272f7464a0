"""Two names are never one scene: what scenes are called by files and folders of any name."""

import os
import unicodedata
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from roomkin.stages.config.inputs import LONGEST, NAME, is_scene, scene_of, scene_of_folder
from roomkin.stages.config.model import load
from roomkin.stages.contracts.types import SceneName
from tests.refusals import refused

PLAIN = [
    *("kitchen", "IMG_1", "IMG_20240501_120000", "a-b", "a_-_b", "0", "000048", "2024-05-01", "IMG_1-3f2a", "Kitchen"),
    *(
        "кухня",
        "ванная",
        "厨房",
        "浴室",
        "キッチン",
        "부엌",
        "مطبخ",
        "מטבח",
        "κουζίνα",
        "Küche",
        "nhà_bếp",
        "рабочий_стол",
    ),
    *("रसोई", "ห้องครัว", "சமையலறை", "სამზარეულო", "½", "x²", "٣"),
]
CHANGED = [
    *(
        "IMG 1",
        "IMG (1)",
        "IMG-(1)",
        "IMG__1",
        "_IMG_1",
        "IMG_1_",
        " IMG_1",
        "IMG.1",
        "IMG,1",
        "IMG#1",
        "IMG%1",
        "IMG+1",
    ),
    *(
        "{x}",
        "{{x}}",
        "[x]",
        "x*",
        "x?",
        "x'",
        'x"',
        "x\\",
        "x$HOME",
        "x`",
        "x|y",
        "x\ny",
        "x\ty",
        "x:y",
        "x;y",
        "-x",
        "--x",
    ),
    *(
        "...",
        "!!!",
        "()",
        "_",
        "-",
        " ",
        "😀",
        "😀😀",
        "❤️",
        "\u0301",
        "x\u200cy",
        "x\u200fy",
        "x\u2028y",
        "厨房 1",
        "кухня (1)",
    ),
    *("a" * 121, "a" * 122, "厨" * 80, "厨" * 81, os.fsdecode(b"k\xff"), os.fsdecode(b"k\xfe"), "nhà bếp", ""),
]


def test_no_two_names_are_one_scene() -> None:
    names = PLAIN + CHANGED
    scenes = {name: scene_of(Path("own", name) if name else Path()) for name in names}
    assert len(set(scenes.values())) == len(names) > 60
    for name, scene in scenes.items():
        assert is_scene(scene) and (scene == name) == (name in PLAIN), name
        TypeAdapter(SceneName).validate_python(scene)
        assert len(os.fsencode(scene)) <= LONGEST and not set(scene) & set("{}[]*?'\"\\$ \n/.,#%") and scene[0] != "-"


def test_a_name_of_ascii_that_paths_may_have_stays_as_it_is() -> None:
    for name in PLAIN:
        assert bool(NAME.fullmatch(name)) == name.isascii(), name


def test_what_is_left_of_a_name_can_be_read() -> None:
    assert scene_of(Path("IMG (1)")).startswith("IMG_1-") and scene_of(Path("😀")).startswith("photo-")
    assert scene_of(Path("❤️")).startswith("photo-")  # of which only an invisible mark would be left
    assert scene_of(Path("厨房 1")).startswith("厨房_1-")
    assert scene_of(Path("a" * 250)).startswith("a" * (LONGEST - 7) + "-")
    assert scene_of(Path("厨" * 80)).startswith("厨" * 37 + "-")  # no half character


def test_accents_may_be_written_in_both_ways() -> None:
    for name in ("Küche", "nhà bếp", "кухня й", "が"):
        parts = unicodedata.normalize("NFD", name)
        assert parts != name and scene_of(Path(parts)) == scene_of(Path(name))
        assert not is_scene(parts)


@pytest.mark.parametrize("name", ["", ".", "..", "a/b", "a/", "-x", "a b", "a.b", "a__b", "{x}", "a" * 121])
def test_what_no_scene_may_be_called(name: str) -> None:
    assert not is_scene(name)


@pytest.mark.parametrize("name", ["-x", "-", "кухня", "a b", "a_", ""])
def test_names_of_other_things_are_ascii(name: str) -> None:
    assert not NAME.fullmatch(name)


@pytest.mark.parametrize("scene", ["厨房", "IMG_1-e21465"])
def test_a_folder_that_the_workflow_made_is_called_as_its_scene(scene: str) -> None:
    for folder in (f"results/photo/{scene}", f"results/scenes/{scene}/frame", f"own/{scene}"):
        assert scene_of_folder(Path(folder)) == scene


def put(*files: str) -> None:
    for file in files:
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        Path(file).touch()


def scenes_of(image: str, **given: object) -> list[str]:
    config = load({"image": image, "depth": "depth.png", "camera": "xtion", **given})
    assert config.experiment.rooms == list(config.experiment.inputs)
    return config.experiment.rooms


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    put("depth.png")
    return tmp_path / "here"


@pytest.mark.parametrize(
    ("image", "scene"),
    [
        ("厨房.png", "厨房"),
        ("own/кухня.jpg", "кухня"),
        ("IMG_1.jpg", "IMG_1"),
        ("IMG 1.jpg", scene_of(Path("IMG 1"))),
        ("a,b.jpg", scene_of(Path("a,b"))),
        ("a\nb.jpg", scene_of(Path("a\nb"))),
        ("kitchen.v2.jpg", scene_of(Path("kitchen.v2"))),
        ("厨房/color.png", "厨房"),
        ("color.png", "color"),
        ("./color.png", "color"),
        ("../color.png", None),
        ("../here/color.png", "here"),
    ],
)
def test_a_picture_s_scene_is_called_as_its_file_or_folder(here: Path, image: str, scene: str | None) -> None:
    put(image)
    assert scenes_of(image) == [scene or scene_of(here.parent)]


def test_recordings_of_like_names_are_scenes_of_their_own(here: Path) -> None:
    for folder in ("rec.1", "rec.2", "录像", "a" * 120):
        put(*(f"{folder}/{kind}/{k}.png" for kind in ("color", "depth") for k in (0, 1)))
    found = [scenes_of(folder, depth="") for folder in ("rec.1", "rec.2", "录像", "a" * 120)]
    assert found[2] == ["录像-0", "录像-1"] and found[0][0].startswith("rec_1-") and found[0][0].endswith("-0")
    scenes = {scene for each in found for scene in each}
    assert len(scenes) == 8 and all(map(is_scene, scenes))


def test_inputs_have_names_that_scenes_may_have(here: Path) -> None:
    put("k.jpg")
    for name in ("厨房", "nhà_bếp"):
        inputs = {name: {"image": "k.jpg", "depth": "depth.png", "fov": 60}}
        assert load({"experiment": {"rooms": [name], "inputs": inputs, "targets": {}}}).experiment.rooms == [name]
    with refused("E-CONFIG-NAME", "experiment.inputs: 'IMG 1' is no name", f"e.g. {scene_of(Path('IMG 1'))}"):
        load({"experiment": {"inputs": {"IMG 1": {"image": "k.jpg", "depth": "depth.png", "fov": 60}}}})
    Path("mine.csv").write_text("scene,image,depth,fov\n厨房,k.jpg,depth.png,60\nIMG 1,k.jpg,depth.png,60\n", "utf-8")
    with refused("E-CONFIG-NAME", "mine.csv, row 3, column scene: 'IMG 1' is no name", "e.g. IMG_1-"):
        load({"experiment": {"rooms": ["*"], "inputs": "mine.csv", "targets": {}}})


def test_a_name_written_in_two_ways_is_one_that_is_there_twice(here: Path) -> None:
    for form in ("NFC", "NFD"):
        put(*(f"own/{unicodedata.normalize(form, 'Küche')}/{name}" for name in ("rgb.png", "camera.json")))
    with refused("E-CONFIG", "there are two scenes 'Küche'. Fix: give one another name"):
        load({"experiment": {"rooms": ["*"], "inputs": "own", "targets": {}}})


def test_folders_of_like_names_are_scenes_of_their_own(here: Path) -> None:
    files = ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json")
    put(*(f"own/{folder}/{name}" for folder in ("IMG 1", "IMG_1", "IMG (1)", "a", "A", "厨房") for name in files))
    config = load({"experiment": {"rooms": ["*"], "inputs": "own", "targets": {}}})
    assert len(config.experiment.rooms) == 6 and {"IMG_1", "a", "A", "厨房"} < set(config.experiment.rooms)


@pytest.mark.parametrize("name", ["{x}.jpg", "-x.jpg", "a{b", "a\n}", os.fsdecode(b"k\xff.jpg")])
def test_a_path_that_no_rule_can_be_given_is_refused(here: Path, name: str) -> None:
    put(name)
    with refused("E-CONFIG-NAME", "image: ", "begins with -, has { or }, or is not UTF-8", "otherwise") as caught:
        scenes_of(name)
    assert "\n" not in str(caught.value)
    folder = Path("own", "kitchen", name)
    put(*(str(folder / each) for each in ("rgb.png", "camera.json", "depth.npz", "masks.png", "annotations.json")))
    if not name.startswith("-"):
        with refused("E-CONFIG-NAME", "experiment.inputs.kitchen: "):
            load({"experiment": {"rooms": ["*"], "inputs": {"kitchen": str(folder)}, "targets": {}}})


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
@pytest.mark.parametrize("key", ["image", "depth"])
def test_what_is_no_file_is_refused_and_not_read(here: Path, key: str, kind: str) -> None:
    put("k.jpg")
    if kind == "pipe":
        os.mkfifo("odd")
    elif kind == "folder":
        Path("odd").mkdir()
    path = "/dev/zero" if kind == "device" else "odd"
    given = {"image": "k.jpg", "depth": "depth.png", "fov": 60} | {key: path}
    with refused("E-CONFIG-FILE", f"experiment.inputs.one.{key}: {path} is no file, but a folder, a pipe or a device"):
        load({"experiment": {"rooms": ["one"], "inputs": {"one": given}, "targets": {}}})


def test_masks_may_be_a_folder(here: Path) -> None:
    put("k.jpg", "depth.png", "masks/0.png")
    given = {"image": "k.jpg", "depth": "depth.png", "fov": 60, "masks": "masks"}
    config = load({"experiment": {"rooms": ["one"], "inputs": {"one": given}, "targets": {}}})
    assert "--masks masks" in config.experiment.inputs["one"].flags(given)
    os.mkfifo("odd")
    with refused("E-CONFIG-FILE", "experiment.inputs.one.masks: odd is no file, but a folder, a pipe or a device"):
        load({"experiment": {"rooms": ["one"], "inputs": {"one": given | {"masks": "odd"}}, "targets": {}}})
