"""`roomkin importing import`: what models are taken for, that corrections count, that the library takes it."""

import io
import json
import re
from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.importing.evidence import Evidence
from roomkin.plugins.importing.import_ import ARROW, describe_left_behind, run
from roomkin.plugins.importing.own import run as own
from roomkin.plugins.importing.tests.own_models import import_folder
from roomkin.plugins.importing.tests.test_fronts import box, cabinet, joint, write_partnet
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import describe_unusual
from roomkin.stages.contracts.errors import InputError
from tests.refusals import refused


@pytest.mark.parametrize(
    ("kind", "turned", "others", "up"),
    [
        ("obj", True, 0, "+y"),
        ("obj", False, 0, "+z"),
        ("obj", True, 1, "+y"),
        ("obj", True, 2, ""),
        ("glb", False, 0, "+z"),
        ("glb", False, 2, ""),
    ],
)
def test_files_of_one_folder_share_the_direction_up(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, turned: bool, others: int, up: str
) -> None:
    def write(mesh: trimesh.Trimesh, name: str, turned: bool) -> None:
        if turned:
            mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
        mesh.export(tmp_path / f"{name}.{kind}")

    (tmp_path / "theirs").mkdir()
    for number in range(3):
        write(trimesh.creation.cone(0.1, 0.2 + 0.1 * number), f"theirs/cone{number}", turned)
    for number in range(others):
        write(trimesh.creation.cone(0.2, 0.2 + 0.1 * number), f"theirs/other{number}", not turned)
    write(trimesh.creation.box((0.3, 0.4, 0.5)), "theirs/block", turned)
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = next(line for line in capsys.readouterr().out.splitlines() if f"block.{kind}" in line)
    assert (f"up {up} as most .{kind} here" in said) == bool(up)
    assert ("50 high" in said) == bool(up), said


def test_files_of_one_folder_share_the_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "theirs").mkdir()
    things = {
        "chair_a": (45, 95, 48),
        "chair_b": (42, 88, 46),
        "sofa": (200, 80, 90),
        "comb": (4, 1, 2),
        "box": (120, 90, 100),
    }
    for name, size in things.items():
        trimesh.creation.box(size).export(tmp_path / f"theirs/{name}.glb")
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = {line.split(": ")[0].rpartition("/")[2]: line for line in capsys.readouterr().out.splitlines()}
    for name, (width, height, depth) in things.items():
        assert f"{width} cm wide, {depth} deep, {height} high" in said[f"{name}.glb"]
        assert "in centimetres as most .glb here" in said[f"{name}.glb"]


def test_unusual_sizes_are_doubted() -> None:
    known = known_categories()
    assert describe_unusual(known["chair"], np.array([0.5, 0.45, 0.9])) == ""
    assert describe_unusual(known.get("gearbox"), np.array([5.0, 4.5, 9.0])) == "", (
        "nobody knows how large such things are"
    )
    assert "is 22 wide × 25 deep × 45 cm high; usual are " in describe_unusual(
        known["chair"], np.array([0.25, 0.22, 0.45])
    )


def test_a_model_tells_the_unit_in_which_it_is_as_large_as_its_category() -> None:
    for extents, up, unit in (
        ((0.5, 0.45, 0.9), "+z", 1.0),
        ((500, 450, 900), "+z", 0.001),
        ((45, 90, 50), "+y", 0.01),
        ((4, 6.4, 3.6), "+y", None),
    ):
        assert Evidence(extents=extents).unit("chair", up) == unit
    assert Evidence(extents=(700, 300, 400)).unit("gearbox", "+z") is None


@pytest.mark.parametrize(
    ("name", "size", "unit", "size_in_cm"),
    [
        ("wheel", (65.0, 65.0, 1.5), "millimetres", "6.5 cm wide, 6.5 deep, 0.15 high"),
        ("chair", (80.0, 80.0, 300.0), "centimetres", "80 cm wide, 80 deep, 300 high"),
        ("table", (40.0, 40.0, 40.0), "inches", "102 cm wide, 102 deep, 102 high"),
    ],
)
def test_units_are_tried_where_metres_are_absurd(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, size: tuple[float, ...], unit: str, size_in_cm: str
) -> None:
    (tmp_path / "theirs").mkdir()
    trimesh.creation.box(size).export(tmp_path / f"theirs/{name}.stl")
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = capsys.readouterr().out
    assert size_in_cm in said and f"in {unit} " in said


def test_own_takes_files_from_its_folder_or_from_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "theirs/chair").mkdir(parents=True)
    trimesh.creation.box((0.45, 0.9, 0.5)).export(tmp_path / "theirs/chair/plain.glb")
    monkeypatch.chdir(tmp_path)
    for number, file in enumerate(("chair/plain.glb", "theirs/chair/plain.glb", tmp_path / "theirs/chair/plain.glb")):
        own(folder=Path("theirs"), models=(f"chair_plain={file}",), out=tmp_path / f"{number}.json")
        assert json.loads((tmp_path / f"{number}.json").read_text())["left_out"] == []
    with refused("E-MODELS-NONE", "chair/gone.glb"):
        own(folder=Path("theirs"), models=("a=chair/gone.glb",), out=tmp_path / "gone.json")


def handleless() -> str:
    parts = f'<link name="body">{box("0.4 0.5 0.6", "-0.21 0 0.3")}</link><link name="d">{box("0.02 0.5 0.5")}</link>'
    return f'<robot name="c">{parts}{joint("slide", "prismatic", "d", "1 0 0", 0.3, "0.01 0 0.3")}</robot>'


@pytest.fixture(scope="module")
def imported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of five models, and what `import` made of it."""
    place = tmp_path_factory.mktemp("import")
    theirs = place / "theirs"
    write_partnet(theirs, "45132", cabinet(180))
    write_partnet(theirs, "45133", cabinet(180))
    write_partnet(theirs, "99", "<robot")
    (theirs / "chest_of_drawers").mkdir()
    (theirs / "chest_of_drawers/bare.urdf").write_text(handleless())
    (theirs / "chair").mkdir()
    trimesh.creation.box((450, 900, 500)).export(theirs / "chair/plain.stl")
    run(theirs, out=place / "mine")
    return place


def test_import_writes_notes_that_say_what_it_took_models_for(imported: Path) -> None:
    def notes(name: str) -> tuple[str, str, float]:
        told = json.loads((imported / "mine" / name / "asset.json").read_text())
        return told["front"], told["up"], told["scale"]

    assert notes("bottom_cabinet/45132") == ("-x", "+z", 1.0)
    assert notes("chair/plain") == ("+z", "+y", 0.001)
    assert notes("chest_of_drawers/bare") == ("+x", "+z", 1.0)
    assert not (imported / "mine/bottom_cabinet/45133").exists(), "a copy"
    assert not (imported / "mine/bottom_cabinet/99").exists(), "cannot be read"


def test_the_library_takes_the_folder_as_it_is(imported: Path, tmp_path: Path) -> None:
    assets = {asset.id: asset for asset in import_folder(imported / "mine", tmp_path / "converted")}
    direct = {asset.id: asset for asset in import_folder(imported / "theirs", tmp_path / "direct")}
    cabinet_asset = assets["bottom_cabinet_45132"]
    assert cabinet_asset.size == pytest.approx(direct["bottom_cabinet_45132"].size, abs=1e-5)
    assert cabinet_asset.mass == pytest.approx(direct["bottom_cabinet_45132"].mass, rel=0.01)
    assert [joint.handle for joint in cabinet_asset.joints] == ["bar", "bar"]
    chair = assets["chair_plain"]
    assert chair.size == pytest.approx((0.5, 0.45, 0.9), abs=1e-6)
    area = 2 * (0.5 * 0.45 + 0.5 * 0.9 + 0.45 * 0.9)
    assert chair.mass == pytest.approx(area / 2 * 0.018 * 500, rel=0.01), "boards, though its file is in millimetres"


def test_page_shows_every_model_with_its_front_and_doubts(imported: Path) -> None:
    page = (imported / "mine/index.html").read_text()
    pictures = re.findall(r'<img src="data:image/webp;base64,([^"]+)"', page)
    assert len(pictures) == 3
    for encoded in pictures:
        shown = np.asarray(Image.open(io.BytesIO(b64decode(encoded))).convert("RGB")).astype(int)
        assert (np.abs(shown - ARROW).max(axis=2) < 40).sum() > 200, "the arrow"
    assert "door &#39;hinge&#39;: 166 degrees, hinge left, handle: bar" in page
    assert "drawer &#39;slide&#39; cannot be grasped" in page
    assert "is a copy of" in page
    assert "is not XML" in page
    assert "http" not in page


def test_corrections_count_when_it_is_run_again(imported: Path, capsys: pytest.CaptureFixture[str]) -> None:
    notes = imported / "mine/chest_of_drawers/bare/asset.json"
    told = json.loads(notes.read_text()) | {"category": "nightstand", "front": "-x", "mass": 7.0}
    notes.write_text(json.dumps(told))
    capsys.readouterr()
    run(imported / "theirs", out=imported / "mine")
    assert json.loads(notes.read_text())["category"] == "nightstand"
    said = re.search(r"bare.urdf: (.*)", capsys.readouterr().out)
    assert said is not None
    assert said[1].startswith("nightstand; 50 cm wide, 43 deep, 60 high, 7 kg; front -x")
    assert "as asset.json says" in said[1]


def test_folders_in_one_another_are_refused(tmp_path: Path) -> None:
    with refused("E-OUT-INSIDE"):
        run(tmp_path, out=tmp_path / "mine")
    (tmp_path / "empty").mkdir()
    with refused("E-MODELS-NONE"):
        run(tmp_path / "empty", out=tmp_path / "mine")


def test_one_file_is_enough_and_parts_alone_are_none(tmp_path: Path) -> None:
    sim = tmp_path / "sim"
    (sim / "box").mkdir(parents=True)
    (sim / "box/part.xml").write_text("<mujocoinclude><geom type='box' size='.3 .2 .1'/></mujocoinclude>")
    model = "<mujoco><worldbody><body><include file='box/part.xml'/></body></worldbody></mujoco>"
    (sim / "wooden_box.xml").write_text(model)
    run(sim / "wooden_box.xml")
    told = json.loads(Path("imported/wooden_box/box/wooden_box/asset.json").read_text())
    assert (told["category"], told["provenance"]) == ("box", "imported: wooden_box.xml")
    with refused("E-MODELS-NONE"):
        run(sim / "box", out=tmp_path / "mine")
    with pytest.raises(InputError, match="give the file that includes it"):
        run(sim / "box/part.xml", out=tmp_path / "mine")
    (sim / "notes.txt").write_text("")
    for name, reason in (("notes.txt", "is no model"), ("gone", "is not there")):
        with pytest.raises(InputError, match=reason):
            run(sim / name, out=tmp_path / "mine")


def test_partnet_models_have_no_size_and_get_a_usual_one(tmp_path: Path) -> None:
    flat = f'<robot name="m"><link name="l">{box("0.9 1.45 0.95")}</link></robot>'
    write_partnet(tmp_path / "theirs", "7167", flat, "Microwave")
    write_partnet(tmp_path / "theirs", "9", flat.replace("0.95", "0.96"), "Gearbox")
    run(tmp_path / "theirs", out=tmp_path / "mine")
    scales = {
        path.parent.name: json.loads(path.read_text())["scale"] for path in (tmp_path / "mine").rglob("asset.json")
    }
    assert scales == {"7167": pytest.approx(0.36, abs=0.03), "9": 1.0}


def test_models_that_are_gone_from_the_source_are_told(tmp_path: Path) -> None:
    for name in ("kept", "gone"):
        (tmp_path / "chair" / name).mkdir(parents=True)
        (tmp_path / "chair" / name / "asset.json").write_text("{}")
    (line,) = describe_left_behind(tmp_path, [tmp_path / "chair/kept"])
    assert line.endswith("delete chair/gone") and not [
        *describe_left_behind(tmp_path, [*(tmp_path / "chair").iterdir()])
    ]


def test_meshes_of_a_model_that_is_not_read_are_no_models(tmp_path: Path) -> None:
    place = tmp_path / "models" / "cabinet" / "meshes"
    place.mkdir(parents=True)
    trimesh.creation.box((0.5, 0.05, 0.5)).export(place / "door.obj")
    uri = "<uri>model://cabinet/meshes/door.obj</uri>"
    (place.parent / "model.sdf").write_text(f"<sdf><mesh>{uri}</mesh></sdf>")
    with refused("E-MODELS-NONE", "only parts", "1 .sdf", "URDF"):
        run(tmp_path / "models", out=tmp_path / "out")
