"""What packs of other people do: files beside the folder, other systems' names, placeholders, robots, whole scenes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.importing import repairs
from roomkin.plugins.importing.discover import discover
from roomkin.plugins.importing.fronts import doors_and_drawers
from roomkin.plugins.importing.import_ import Portraits, run
from roomkin.plugins.importing.importers.mjcf import read_mjcf
from roomkin.plugins.importing.repairs import repair_inertias
from roomkin.plugins.importing.sandbox import number_names, strip_name
from roomkin.plugins.importing.tests.test_fronts import box, joint
from roomkin.stages.articulated.asset_folder import assign_part_types, contract_joints
from roomkin.stages.articulated.mesh_writer import write_glb
from roomkin.stages.articulated.model import Link
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.contracts.categories import category_in
from tests.refusals import refused


def urdf(path: Path, body: str, before: str = "", after: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'{before}<robot name="r">{body}</robot>{after}')
    return path


def mesh_link(name: str) -> str:
    return f'<link name="a"><visual><geometry><mesh filename="{name}"/></geometry></visual></link>'


def mjcf(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<mujoco>{text}</mujoco>")
    return path


def test_a_file_beside_the_folder_tells_which_folder_to_give(tmp_path: Path) -> None:
    (tmp_path / "pack/meshes").mkdir(parents=True)
    trimesh.creation.box().export(tmp_path / "pack/meshes/a.obj")
    model = urdf(tmp_path / "pack/objects/a.urdf", mesh_link("../meshes/a.obj"))
    with refused("E-FILE-MISSING", f"Fix: give {tmp_path}/pack in its place"):
        read_urdf(model, model.parent)
    include = mjcf(tmp_path / "pack/objects/a.xml", '<asset><mesh file="../meshes/a.obj"/></asset><worldbody/>')
    with refused("E-FILE-OUTSIDE", "'../meshes/a.obj', outside of objects/. Fix: copy it there"):
        read_mjcf(include, include.parent)
    with refused("E-FILE-MISSING", "Fix: copy it there"):
        read_urdf(urdf(model, mesh_link("../meshes/gone.obj")), model.parent)


def test_names_with_backslashes(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    trimesh.creation.box().export(tmp_path / "meshes/a.obj")
    assert read_urdf(urdf(tmp_path / "a.urdf", mesh_link(r"meshes\a.obj")), tmp_path).links["a"].visuals


def test_names_with_other_capital_letters(tmp_path: Path) -> None:
    (tmp_path / "arm/Meshes").mkdir(parents=True)
    trimesh.creation.box().export(tmp_path / "arm/Meshes/base_link.stl")
    model = urdf(tmp_path / "arm/urdf/arm.urdf", mesh_link("package://arm/meshes/Base_Link.STL"))
    assert read_urdf(model, tmp_path).links["a"].visuals
    (tmp_path / "arm/Meshes/base_link.stl").rename(tmp_path.parent / "other.stl")
    (tmp_path / "arm/Meshes/base_link.stl").symlink_to(tmp_path.parent / "other.stl")
    with refused("E-FILE-OUTSIDE", "but a link out of it"):
        read_urdf(model, tmp_path)


def test_sloppy_xml_is_read(tmp_path: Path) -> None:
    link = f'<!-- <!-- a --><link name="a" sim:id="1">{box("0.1 0.2 0.3", "1, 2, 3")}<sim:mu x="1"/></link>'
    model = urdf(tmp_path / "a.urdf", link, '\n \n<?xml version="1.0"?>', "\n\0")
    model.write_text(model.read_text().replace("<robot", '<robot xmlns="http://x.org" xmlns:s="http://y.org"'))
    assert read_urdf(model, tmp_path).links["a"].visuals[0].mesh.bounds.mean(axis=0) == pytest.approx([1, 2, 3])


def test_a_world_that_nobody_declares(tmp_path: Path) -> None:
    weld = '<joint name="weld" type="fixed"><parent link="world"/><child link="a"/></joint>'
    robot = read_urdf(urdf(tmp_path / "a.urdf", f'<link name="a">{box("1 1 1")}</link>{weld}'), tmp_path)
    assert robot.root == "world" and robot.links["a"].visuals


def test_points_that_collide_are_left_out(tmp_path: Path) -> None:
    point = '<collision><geometry><sphere radius="1e-7"/></geometry></collision>'
    urdf(tmp_path / "theirs/mug/a.urdf", f'<link name="a">{box("0.1 0.1 0.1")}{point}</link>')
    run(tmp_path / "theirs", out=tmp_path / "mine")
    assert (tmp_path / "mine/mug/a/asset.json").is_file()


def moving(
    tmp_path: Path, shape: str, kind: str, axis: str, upper: float, beyond: str = "", body: bool = True
) -> list[str]:
    """What is said of a model with one joint."""
    base = f'<link name="body">{box("0.4 0.5 0.6", "-0.21 0 0.3") if body else ""}</link>'
    text = f'{base}<link name="part">{shape}</link>{joint("j", kind, "part", axis, upper, "0.01 -0.25 0.3")}{beyond}'
    return doors_and_drawers(read_urdf(urdf(tmp_path / "a.urdf", text), tmp_path))[1]


def test_levers_and_loose_things_are_no_doors(tmp_path: Path) -> None:
    panel, hinge = box("0.02 0.5 0.5", "0 0.25 0"), "0 0 -1"
    assert moving(tmp_path, panel, "revolute", hinge, 1.5) == []
    assert "front of some size" in moving(tmp_path, box("0.02 0.5 0.04", "0 0.25 0"), "revolute", hinge, 1.5)[0]
    assert "moves all that is seen" in moving(tmp_path, box("0.3 0.3 0.3"), "prismatic", "1 0 0", 0.4, body=False)[0]


def test_inertias_that_nothing_has_are_those_of_boxes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tensor = '<inertia ixx="0.2125" ixy="-0.005" ixz="0.0225" iyy="0.205" iyz="0.045" izz="0.0125"/>'
    plain = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.12"/>'
    far = plain.replace("0.12", "0.3")
    for number, (name, inertia) in enumerate({"odd": tensor, "far": far, "plain": plain}.items()):
        link = f'<inertial><mass value="6"/>{inertia}</inertial>{box(f"0.4 0.5 0.3{number}")}'
        foot = f'<link name="b">{box("0.1 0.1 0.1")}</link>'
        bolt = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
        urdf(tmp_path / f"theirs/{name}.urdf", f'<link name="a">{link}</link>{foot}{bolt}')
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = capsys.readouterr().out
    assert "3 of 3 models can be used" in said
    assert said.count("inertia of 'a' taken for that of a box") == 1, "a rod's is possible"


@pytest.mark.parametrize("what", ["picture", "physics"])
def test_what_the_simulator_does_not_take_stops_no_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    for name in ("good", "bad"):
        urdf(tmp_path / f"theirs/{name}.urdf", f'<link name="a">{box("0.4 0.5 0.3")}</link>')

    def refuse(real: Any, place: int) -> Any:
        def call(*given: Any, **options: Any) -> Any:
            if "bad" in str(given[place]):
                raise RuntimeError("out of its mind")
            return real(*given, **options)

        return call

    if what == "picture":
        monkeypatch.setattr(Portraits, "take", refuse(Portraits.take, 1))
    else:
        monkeypatch.setattr(repairs, "load_asset", refuse(repairs.load_asset, 1))
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = capsys.readouterr().out
    assert "1 of 2 models can be used" in said
    assert "bad.urdf: not used: " in said and "out of its mind" in said


def test_folders_whose_names_say_nothing(tmp_path: Path) -> None:
    for path in (
        "assets/objects/can-visual.urdf",
        "assets/objects/study_table.urdf",
        "assets/mug/urdf/model.urdf",
        "assets/urdf/parts/drawer/drawer_top.urdf",
        "assets/urdf/parts/chair/model.urdf",
        "crate/big/box.urdf",
        "chair/blue/a.urdf",
        "chair/blue/b.urdf",
        "lamp/7/mobility.urdf",
        "output/cabinet_panel.urdf",
        "output/cabinet.urdf",
    ):
        urdf(tmp_path / path, "")
    assert {(one.category, one.name) for one in discover(tmp_path, [".urdf"])} == {
        ("can", "can-visual"),
        ("table", "study_table"),
        ("mug", "mug"),
        ("drawer", "drawer"),
        ("chair", "chair"),
        ("box", "big"),
        ("chair", "a"),
        ("chair", "b"),
        ("table_lamp", "7"),
        ("cabinet_panel", "cabinet_panel"),
        ("bottom_cabinet", "cabinet"),
    }
    assert number_names(["a", "a", "b", "a_2", "a"], ["b"]) == ["a", "a_2", "b_2", "a_2_2", "a_3"]
    assert [strip_name(name) for name in ("011_banana", "banana_model_obj", "mesh")] == ["banana", "banana", "mesh"]


def test_what_a_collection_holds_is_called_as_it_is(tmp_path: Path) -> None:
    for path in ("things/milk/milk.urdf", "things/cup/cup.urdf", "gizmos/a.urdf", "gizmos/b.urdf"):
        urdf(tmp_path / path, "")
    assert {one.category for one in discover(tmp_path, [".urdf"])} == {"milk", "mug", "gizmos"}
    told = {
        "desk_caddy": None, "table_leg_2": None, "bowl_drainer": None, "fridge_door": None, "tv_stand": "tv_stand",
        "chest_of_drawers": "chest_of_drawers", "cabinet_2_doors": "bottom_cabinet", "mug_with_handle": "mug",
        "bedsideTable2": "nightstand", "kitchenUpperCabinet": "wall_cabinet", "8_frypan": "pan",
        "kitchenCabinetDrawer": "bottom_cabinet", "chest_drawers": "chest_of_drawers"
    }  # fmt: skip
    assert {name: category_in(name) for name in told} == told


def test_kinds_of_files_that_are_in_metres_stay_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    urdf(tmp_path / "theirs/arena.urdf", f'<link name="a">{box("6 5 3")}</link>')
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = capsys.readouterr().out
    assert "500 cm wide, 600 deep, 300 high" in said


def test_import_says_what_it_only_assumes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    trimesh.creation.box((0.7, 0.5, 0.3)).export(theirs / "gears.glb")
    sheet = trimesh.creation.box((1, 1, 0.1)).slice_plane([0, 0, 0], [0, 0, 1])
    sheet.vertices[:, 2] = 0
    flat, askew = sheet.copy(), sheet.copy()
    askew.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 0.3, 0]))
    flat.export(theirs / "cloth.obj")
    askew.export(theirs / "ramp.obj")
    run(theirs, out=tmp_path / "mine")
    said = {line.split(": ")[0].rpartition("/")[2]: line for line in capsys.readouterr().out.splitlines()}
    assert "front assumed" in said["gears.glb"], "glTF has an agreed direction up"
    for name in ("cloth.obj", "ramp.obj"):
        assert f"{name}: not used: is flat" in said[name]


def test_large_textures_are_made_smaller(tmp_path: Path) -> None:
    mesh, picture = trimesh.creation.box(), Image.new("RGB", (3000, 1500))
    mesh.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), image=picture)
    write_glb(tmp_path / "a.glb", [mesh])
    (written,) = trimesh.load_scene(tmp_path / "a.glb").geometry.values()
    assert written.visual.material.baseColorTexture.size == (1024, 512)
    assert picture.size == (3000, 1500)


def test_kinds_that_are_not_read_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "theirs/chair").mkdir(parents=True)
    (tmp_path / "theirs/chair/a.usd").write_text("")
    (tmp_path / "theirs/chair/a.kinbody.xml").write_text("<KinBody/>")
    with refused("E-MODELS-NONE"):
        run(tmp_path / "theirs", out=tmp_path / "mine")
    trimesh.creation.box((0.5, 0.5, 0.9)).export(tmp_path / "theirs/chair/b.stl")
    run(tmp_path / "theirs", out=tmp_path / "mine")
    assert "not read (1 .kinbody.xml, 1 .usd)" in capsys.readouterr().err


def test_a_drawer_behind_a_door_has_no_handle_to_hold(tmp_path: Path) -> None:
    drawer = box("0.02 0.4 0.2") + box("0.03 0.2 0.02", "0.02 0 0")
    inside = f'<link name="d">{drawer}</link>{joint("slide", "prismatic", "d", "1 0 0", 0.3, "-0.06 0 0.3")}'
    body = f'<link name="body">{box("0.4 0.5 0.6", "-0.31 0 0.3")}</link>'

    def handle(more: str) -> str | None:
        robot = read_urdf(urdf(tmp_path / "a.urdf", body + inside + more), tmp_path)
        (found,) = (one for one in contract_joints(assign_part_types(robot)) if one.name == "slide")
        return found.handle

    door = f'<link name="door">{box("0.02 0.5 0.6", "0 0.25 0")}</link>'
    assert handle("") == "bar"
    assert handle(door + joint("hinge", "revolute", "door", "0 0 -1", 1.5, "0.02 -0.25 0.3")) is None


@pytest.mark.parametrize(
    ("size", "mass", "says"),
    [
        ("0.35 0.6 0.7", 0.45, "weighs 0.45 kg in its file"),
        ("0.35 0.6 0.7", 15, ""),
        ("0.35 0.6 0.7", 2000, "weighs 2e+03 kg in its file"),
        ("1 1 1.6", 5, "weighs 5 kg, less than anything of its size"),
        ("6 6 2.5", 900, "is 6 by 6 m: a whole room is no model"),
    ],
)
def test_masses_and_sizes_that_no_thing_has_are_doubted(tmp_path: Path, size: str, mass: float, says: str) -> None:
    text = f'<link name="a">{box(size)}<inertial><mass value="{mass}"/></inertial></link>'
    lines = repair_inertias(read_urdf(urdf(tmp_path / "a.urdf", text), tmp_path))[1]
    assert [line.startswith(says) for line in lines] == [True] * bool(says)


def _drawer(folder: Path, kilograms: float) -> tuple[Link, list[str]]:
    """A drawer that weighs so much in its file, weighed sanely, and what is said of it."""
    parts = box("0.02 0.5 0.2") + box("0.3 0.45 0.15", "-0.16 0 0")
    inertial = f'<inertial><mass value="{kilograms}"/><inertia ixx="{kilograms / 30}" iyy="{kilograms / 60}" '
    inertial += f'izz="{kilograms / 40}" ixy="0" ixz="0" iyz="0"/></inertial>'
    text = f'<robot name="r"><link name="body">{box("0.4 0.5 0.6", "-0.21 0 0.3")}</link><link name="d">{inertial}'
    text += f"{parts}</link>{joint('slide', 'prismatic', 'd', '1 0 0', 0.3, '0.01 0 0.3')}</robot>"
    (folder / "a.urdf").write_text(text)
    robot, lines = repair_inertias(read_urdf(folder / "a.urdf", folder))
    return robot.links["d"], lines


def test_what_is_taken_for_boards_turns_as_if_it_were_of_boards(tmp_path: Path) -> None:
    (kept, nothing), (lighter, lines) = _drawer(tmp_path, 4.0), _drawer(tmp_path, 4000.0)
    assert nothing == []
    assert lines[-1:] == [f"what 'slide' moves weighs 4e+03 kg in its file: taken for boards, {lighter.mass:.2g} kg"]
    assert kept.mass == 4.0 and 2 < lighter.mass < 6
    np.testing.assert_allclose(np.diag(kept.inertia), [4 / 30, 4 / 60, 4 / 40])
    assert lighter.inertia / lighter.mass == pytest.approx(kept.inertia / kept.mass)
