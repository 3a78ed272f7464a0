"""Pictures by the table or the folder: what a row may say, and what is said of a row that is wrong."""

from pathlib import Path
from typing import Any

import pytest

from roomkin.plugins.ops.outside import list_outside_paths
from roomkin.stages.config.inputs import INPUT_FILES
from roomkin.stages.config.model import load
from roomkin.stages.config.pictures import Picture
from roomkin.stages.contracts import InputError

HEAD = "scene,image,depth,unit,camera,fx,fy,cx,cy,fov,masks,labels,folder,recording,number"


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A data set: a picture, its depth and masks, two input folders. The working directory is another one."""
    data = tmp_path / "data"
    for folder in ("many/kitchen", "many/hall"):
        (data / folder).mkdir(parents=True)
        for name in INPUT_FILES:
            (data / folder / name).touch()
    for name in ("a.png", "a_depth.png", "k.json", "masks.json"):
        (data / name).touch()
    (data / "recording").mkdir()
    (data / "many/notes").mkdir()
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return data


def table(data: Path, *rows: str, head: str = HEAD, name: str = "pictures.csv") -> str:
    (data / name).write_text("\n".join([head, *rows, ""]))
    return f"../data/{name}"


def config(inputs: Any, rooms: list[str] | None = None) -> Any:
    return load({"experiment": {"inputs": inputs, "rooms": rooms or ["*"], "targets": {"door": None}}}).experiment


def lines(inputs: Any, rooms: list[str] | None = None) -> list[str]:
    with pytest.raises(InputError) as caught:
        config(inputs, rooms)
    return [line.strip() for line in str(caught.value).removeprefix("config: ").split("\n") if "mistakes:" not in line]


def test_every_row_is_a_scene_with_files_beside_the_table(data: Path) -> None:
    found = config(
        table(
            data,
            "one,a.png,a_depth.png,5000,k.json,,,,,,masks.json,,,,",
            "two,a.png,a_depth.png,,realsense_d435,,,,,,,,,,",
            "",
            "three,a.png,a_depth.png,mm,,600,601,320,240,,masks.json,,,,",
            f"four,{data}/a.png,a_depth.png,,,,,,,69,masks.json,,,,",
            "five,,,,,,,,,,,,many/hall,,",
            "six,,,,,,,,,,,,,recording,7",
        )
    )
    assert found.rooms == ["one", "two", "three", "four", "five", "six"]
    one, two, three, four, five, six = (found.inputs[name] for name in found.rooms)
    names = {"image": "a.png", "depth": "a_depth.png", "masks": "masks.json", "camera": "k.json"}
    assert one.files() == {key: f"../data/{name}" for key, name in names.items()}
    assert one.unit == "5000" and two.camera == "realsense_d435" and not two.masks and "camera" not in two.files()
    assert three.intrinsics == [600, 601, 320, 240] and four.fov == 69 and four.image == f"{data}/a.png"
    assert five.place("five") == "../data/many/hall" and one.place("one") == "results/scenes/one/frame"
    assert six.files() == {"recording": "../data/recording"} and six.number == 7


@pytest.mark.parametrize("sign", [";", "\t"])
def test_other_signs_between_cells(data: Path, sign: str) -> None:
    rows = ("\ufeffscene,folder", "kitchen,many/kitchen")
    (data / "t.tsv").write_text("\n".join(rows).replace(",", sign), encoding="utf-8")
    assert config("../data/t.tsv").inputs["kitchen"].folder == "../data/many/kitchen"


def test_a_folder_of_folders_and_lists(data: Path) -> None:
    assert config("../data/many").rooms == ["hall", "kitchen"]  # notes/ holds nothing of a scene
    assert config("../data/many/hall").inputs == {"hall": Picture(folder="../data/many/hall")}
    both = ["../data/many", table(data, "desk,a.png,a_depth.png,,k.json,,,,,,masks.json,,,,")]
    assert config(both, ["room_1", "ha*", "desk"]).rooms == ["room_1", "desk", "hall"]
    assert lines([*both, "../data/many"]) == [
        f"../data/many/{name}: there are two scenes '{name}'. Fix: give one another name"
        for name in ("hall", "kitchen")
    ]


def test_an_input_by_hand_may_say_what_a_row_says(data: Path) -> None:
    frame = {"image": "../data/a.png", "depth": "../data/a_depth.png", "camera": "xtion"}
    assert config({"desk": frame, "hall": "../data/many/hall"}).inputs["desk"].camera == "xtion"
    assert lines({"desk": frame | {"depth": "../data/b.png"}}) == [
        "experiment.inputs.desk.depth: no file ../data/b.png. Fix: correct the path"
    ]
    assert lines({"desk": frame | {"depht": "x"}}, ["room_1"])[0].endswith("unknown key. Fix: did you mean 'depth'?")


GOOD = "one,a.png,a_depth.png,,k.json,,,,,,masks.json,,,,"


@pytest.mark.parametrize(
    ("row", "column", "words"),
    [
        ("two,b.png,a_depth.png,,k.json,,,,,,masks.json,,,,", "image", "no file ../data/b.png"),
        ("two,a.png,a_depth.png,,realsens,,,,,,masks.json,,,,", "camera", "realsense_d435"),
        ("two,a.png,a_depth.png,,,,,,,,masks.json,,,,", "camera", "what camera took the picture"),
        ("two,a.png,a_depth.png,,,600,,320,240,,masks.json,,,,", "camera", "fx, fy, cx and cy"),
        ("two,a.png,a_depth.png,,k.json,,,,,60,masks.json,,,,", "camera", "given in two ways"),
        ("two,a.png,a_depth.png,,,,,,,170,masks.json,,,,", "fov", "less than or equal to 135 (got '170')"),
        ("two,a.png,a_depth.png,,,6x,6,3,2,,masks.json,,,,", "fx", "valid number"),
        ("two,a.png,,m,,,,,,,,,,,", "unit", "picture without depth"),
        ("two,,a_depth.png,,k.json,,,,,,masks.json,,,,", "image", "image, folder or recording"),
        ("two,a.png,,,,,,,,,,,,recording,", "recording", "leave out image and depth"),
        ("two,,,,,,,,,,,,many/attic,,", "folder", "no folder ../data/many/attic"),
        ("two,,,,,,,,,,,,many/notes,,", "folder", "../data/many/notes has no depth.npz"),
        ("two,,,,,,,,,60,,,many/hall,,", "fov", "given together with a folder"),
        ("two tables,,,,,,,,,,,,many/hall,,", "scene", "'two tables' is no name"),
        (",,,,,,,,,,,,many/hall,,", "scene", "'' is no name"),
    ],
)  # fmt: skip
def test_a_wrong_row_is_told_by_file_row_and_column(data: Path, row: str, column: str, words: str) -> None:
    told = lines(table(data, GOOD, row))
    assert any(one.startswith(f"../data/pictures.csv, row 3, column {column}: ") and words in one for one in told), told
    assert all("row 3" in one or "weights" in one for one in told) and "Fix: " in told[0]


def test_a_wrong_table_is_one_line(data: Path) -> None:
    assert lines(table(data, "x", head="scene,depht")) == [
        "../data/pictures.csv, row 1: column 'depht' is not known, or there twice. Fix: did you mean 'depth'?"
    ]
    assert "has no column 'scene'" in lines(table(data, "x", head="image"))[0]
    assert "row 2: has 3 cells for 2 columns" in lines(table(data, "a,b,c", head="scene,folder"))[0]
    assert lines("../data/nothing.csv")[0].startswith("experiment.inputs: ../data/nothing.csv: no such file or folder")
    (data / "bytes.csv").write_bytes(b"scene,image\n\xff\xfe,x\n")
    assert "bytes.csv" in lines("../data/bytes.csv")[0]
    assert "has no input folder in it" in lines("../data/recording")[0]
    assert "row 3: there are two scenes 'one'" in lines(table(data, GOOD, GOOD))[0]


def test_a_pattern_that_fits_nothing_is_no_scene(data: Path) -> None:
    assert lines("../data/many", ["kit*", "attic_*"])[0].startswith("experiment.rooms: unknown scene 'attic_*'. Fix: ")


def test_rows_that_are_not_asked_for_may_be_wrong(data: Path) -> None:
    rows = table(data, GOOD, "two,b.png,a_depth.png,,k.json,,,,,,masks.json,,,,")
    assert config(rows, ["one"]).rooms == ["one"]


def test_containers_see_the_folders_of_many_pictures(data: Path) -> None:
    (data / "pictures").mkdir()
    names = [f"s{number}" for number in range(50)]
    for name in names:
        for end in (".png", "_d.png", "_m.png"):
            (data / f"pictures/{name}{end}").touch()
    rows = [f"{name},pictures/{name}.png,pictures/{name}_d.png,xtion,pictures/{name}_m.png" for name in names]
    many = table(data, *rows, head="scene,image,depth,camera,masks")
    loaded = load({"experiment": {"inputs": many, "rooms": ["*"], "targets": {"door": None}}})
    assert list_outside_paths(loaded) == [str(data / "pictures")]
