"""What an imported articulation is taken for: front, doors and drawers, masses; PartNet folders as they are."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import sapien
import trimesh

from roomkin.plugins.importing.discover import discover
from roomkin.plugins.importing.fronts import doors_and_drawers, front_direction
from roomkin.plugins.importing.repairs import stuck_joints, with_solid_handles
from roomkin.plugins.importing.tests.own_models import import_folder
from roomkin.stages.articulated.asset_folder import assign_part_types, contract_joints, read_model
from roomkin.stages.articulated.handle import find_handle
from roomkin.stages.articulated.model import link_frames
from roomkin.stages.articulated.resizing import resize_asset
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.contracts.categories import category_in
from roomkin.stages.simulation.loading import load_asset, physics_scene

FACING = {"+x": 0, "+y": 90, "-x": 180, "-y": 270}


def box(size: str, xyz: str = "0 0 0") -> str:
    return f'<visual><origin xyz="{xyz}"/><geometry><box size="{size}"/></geometry></visual>'


def joint(name: str, kind: str, child: str, axis: str, upper: float, xyz: str, parent: str = "body") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="{axis}"/><limit lower="0" upper="{upper}" effort="1" velocity="1"/></joint>'
    )


def cabinet(turn: float = 0.0) -> str:
    """A cabinet whose front faces +x before it is turned: a door, a drawer, and four joints that are neither."""
    parts = {
        "door": box("0.02 0.5 0.4", "0 0.25 0") + box("0.03 0.02 0.2", "0.03 0.4 0"),
        "drawer": box("0.02 0.5 0.2") + box("0.3 0.45 0.15", "-0.16 0 0") + box("0.03 0.2 0.02", "0.03 0 0"),
        "button": box("0.02 0.02 0.02"),
        "tray": box("0.3 0.3 0.06"),
        "dial": box("0.03 0.08 0.08"),
    }
    links = "".join(f'<link name="{name}">{shape}</link>' for name, shape in parts.items())
    joints = [
        joint("hinge", "revolute", "door", "0 0 -1", 2.9, "0.21 -0.25 0.25"),
        joint("slide", "prismatic", "drawer", "1 0 0", 0.25, "0.21 0 0.6"),
        joint("press", "prismatic", "button", "1 0 0", 0.01, "0.21 0.2 0.75"),
        joint("sideways", "prismatic", "tray", "0 1 0", 0.3, "0 0 0.85"),
        joint("turn", "revolute", "dial", "1 0 0", 3.0, "0.21 -0.2 0.75"),
        joint("helper", "revolute", "empty", "0 0 1", 3.0, "0 0 0"),
    ]
    stand = (
        '<link name="world"/><joint name="stand" type="fixed"><parent link="world"/><child link="body"/>'
        f'<origin rpy="0 0 {np.deg2rad(turn)}"/></joint>'
    )
    body = f'<link name="body">{box("0.4 0.5 0.8", "0 0 0.4")}</link><link name="empty"/>'
    return f'<robot name="c">{stand}{body}{links}{"".join(joints)}</robot>'


@pytest.mark.parametrize(("side", "turn"), FACING.items())
def test_front_is_where_doors_and_drawers_open(tmp_path: Path, side: str, turn: float) -> None:
    (tmp_path / "c.urdf").write_text(cabinet(turn))
    found = front_direction(read_urdf(tmp_path / "c.urdf", tmp_path))
    assert found is not None
    direction, count = found
    assert direction == pytest.approx([np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn)), 0], abs=1e-9)
    assert count == 2, "the tray slides sideways, the button hardly at all"


def test_a_door_in_the_back_half_faces_where_it_swings_to(tmp_path: Path) -> None:
    island = '<link name="island">' + box("0.6 0.5 0.8", "2 0 0.4") + "</link>"
    beside = '<joint name="beside" type="fixed"><parent link="body"/><child link="island"/></joint>'
    (tmp_path / "c.urdf").write_text(cabinet().replace("</robot>", island + beside + "</robot>"))
    found = front_direction(read_urdf(tmp_path / "c.urdf", tmp_path))
    assert found is not None and found[0] == pytest.approx([1, 0, 0]) and found[1] == 2


def test_a_front_is_as_askew_as_most_of_its_area_not_most_of_its_faces(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((0.1, 0.01, 0.1))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.3, (0, 0, 1)))
    mesh.subdivide().subdivide().export(tmp_path / "knob.obj")  # many faces, little area
    knob = '<visual><origin xyz="0.05 0.2 0"/><geometry><mesh filename="knob.obj"/></geometry></visual>'
    (tmp_path / "c.urdf").write_text(cabinet().replace('<link name="door">', '<link name="door">' + knob))
    robot, lines = doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))
    assert [joint.name for joint in robot.joints if joint.type != "fixed"] == ["hinge", "slide"], lines


def test_a_sliding_door_and_one_askew_are_fixed_with_the_reason(tmp_path: Path) -> None:
    shutter = box("0.25 0.02 0.7") + box("0.02 0.05 0.2", "0.1 0.03 0")
    wall = '<link name="shutter">' + shutter + "</link>"
    slide = joint("shut", "prismatic", "shutter", "1 0 0", 0.14, "-0.07 0.26 0.4")
    askew = cabinet().replace('xyz="0.21 -0.25 0.25"', 'xyz="0.21 -0.25 0.25" rpy="0 0 0.3"')
    (tmp_path / "c.urdf").write_text(askew.replace("</robot>", wall + slide + "</robot>"))
    robot, lines = doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))
    assert [joint.name for joint in robot.joints if joint.type != "fixed"] == ["slide"]
    assert "fixed, as no door or drawer: 'shut' (slides along what it is in)" in lines
    assert "fixed, as no door or drawer: 'hinge' (stands 17 degrees askew)" in lines
    endless = joint("shut", "prismatic", "shutter", "1 0 0", 20.0, "-0.07 0.26 0.4")
    (tmp_path / "c.urdf").write_text(askew.replace("</robot>", wall + endless + "</robot>"))
    lines = doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))[1]
    assert "fixed, as no door or drawer: 'shut' (slides along what it is in)" in lines
    far = joint("shut", "prismatic", "shutter", "1 0 0", 0.3, "-0.07 0.26 0.4")  # out of the box, from behind its front
    (tmp_path / "c.urdf").write_text(askew.replace("</robot>", wall + far + "</robot>"))
    assert "'shut' (slides along what it is in)" in str(doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))[1])


@pytest.mark.parametrize("own", [True, False], ids=["a box in the file", "one hull"])
def test_a_handle_that_is_seen_is_solid(tmp_path: Path, own: bool) -> None:
    """A door with its handle as one mesh: a box or a hull around it would leave nothing to hold."""
    parts = {(0.02, 0.5, 0.4): (0, 0, 0), (0.012, 0.012, 0.16): (0.045, 0.2, 0)}
    parts |= {(0.045, 0.012, 0.012): (0.025, 0.2, 0.074), (0.0451, 0.012, 0.012): (0.025, 0.2, -0.074)}
    boxes = [trimesh.creation.box(size, trimesh.transformations.translation_matrix(at)) for size, at in parts.items()]
    trimesh.boolean.union(boxes).export(tmp_path / "door.obj")
    mesh = '<visual><origin xyz="0 0.25 0"/><geometry><mesh filename="door.obj"/></geometry></visual>'
    door = mesh + (box("0.02 0.5 0.4", "0 0.25 0").replace("visual", "collision") if own else "")
    before = box("0.02 0.5 0.4", "0 0.25 0") + box("0.03 0.02 0.2", "0.03 0.4 0")
    (tmp_path / "c.urdf").write_text(cabinet().replace(before, door))
    robot = assign_part_types(doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))[0])
    solid, lines = with_solid_handles(robot)
    assert lines == ["door 'hinge': what collides hid its handle: cut anew from what is seen"]
    handle = find_handle(trimesh.util.concatenate(solid.links["door"].collisions))
    assert handle is not None and handle.width < 0.02 and handle.position[1] == pytest.approx(0.45, abs=0.005)
    assert with_solid_handles(solid)[1] == [], "once is enough"
    assert solid.links["drawer"] is robot.links["drawer"]


@pytest.mark.parametrize(("width", "kind"), [(0.05, "bar"), (0.09, None)])
def test_what_a_gripper_cannot_close_on_is_no_handle(tmp_path: Path, width: float, kind: str | None) -> None:
    text = cabinet().replace("0.03 0.02 0.2", f"0.03 {width} 0.2").replace("0.03 0.4 0", "0.03 0.3 0")
    (tmp_path / "c.urdf").write_text(text)
    robot = assign_part_types(doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))[0])
    assert next(joint.handle for joint in contract_joints(robot) if joint.name == "hinge") == kind


def test_only_doors_and_drawers_move(tmp_path: Path) -> None:
    (tmp_path / "c.urdf").write_text(cabinet())
    robot, doubts = doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))
    assert [joint.name for joint in robot.joints if joint.type != "fixed"] == ["hinge", "slide"]
    assert doubts == [
        "fixed, as no door or drawer: 'press' (slides by less than 5 cm)",
        "fixed, as no door or drawer: 'sideways' (opens to another side than the front)",
        "fixed, as no door or drawer: 'turn' (turns no panel about its side)",
        "fixed, as no door or drawer: 'helper' (moves nothing that is seen)",
    ]
    before = link_frames(read_urdf(tmp_path / "c.urdf", tmp_path))
    after = link_frames(robot)
    assert all(np.allclose(before[name], after[name]) for name in before), "everything stays where it was, closed"


def rubbing(gap: float) -> str:
    """Two drawers one above the other, `gap` apart (negative: they overlap)."""
    parts = "".join(
        f'<link name="{name}">{box("0.3 0.4 0.2") + box("0.03 0.2 0.02", "0.16 0 0")}</link>' for name in "ab"
    )
    joints = joint("low", "prismatic", "a", "1 0 0", 0.2, "0.05 0 0.1") + joint(
        "high", "prismatic", "b", "1 0 0", 0.2, f"0.05 0 {0.3 + gap}"
    )
    return f'<robot name="c"><link name="body">{box("0.02 0.5 0.6", "-0.2 0 0.3")}</link>{parts}{joints}</robot>'


@pytest.mark.parametrize(("gap", "pairs"), [(-0.001, [("a", "b")]), (0.01, [])])
def test_parts_that_touch_when_closed_pass_through_each_other(
    tmp_path: Path, gap: float, pairs: list[tuple[str, str]]
) -> None:
    place = tmp_path / "mine" / "chest_of_drawers" / "rubbing"
    place.mkdir(parents=True)
    (place / "a.urdf").write_text(rubbing(gap))
    (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
    folder = tmp_path / "models" / asset.id
    assert list(read_model(folder).touching) == pairs
    assert (folder / "model.srdf").exists() == bool(pairs)
    sized = resize_asset(folder, (0.5, 0.6, 0.7), tmp_path / "sized")
    assert list(read_model(sized).touching) == pairs
    assert stuck_joints(folder) == []


def test_parts_that_touch_pass_through_parts_of_their_own_body_alone(tmp_path: Path) -> None:
    """SAPIEN tells pairs apart by bits, which other bodies, the robot among them, have as well."""
    place = tmp_path / "mine" / "chest_of_drawers" / "rubbing"
    place.mkdir(parents=True)
    (place / "a.urdf").write_text(rubbing(-0.001))
    (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
    scene = physics_scene(timestep=1e-5)
    for x in (0.0, 0.1):
        load_asset(scene, tmp_path / "models" / asset.id, sapien.Pose([x, 0, 0]), True, f"at {x}")
    scene.step()
    touching = [{body.articulation.name for body in contact.bodies} for contact in scene.get_contacts()]
    assert touching and all(len(bodies) == 2 for bodies in touching)
    a_and_b = ({body.entity.name for body in contact.bodies} for contact in scene.get_contacts())
    assert {"a", "b"} in list(a_and_b), "of two bodies"


def test_a_joint_that_sticks_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / "mine" / "chest_of_drawers" / "barred"
    place.mkdir(parents=True)
    bar = '<link name="bar">' + box("0.02 0.6 0.2", "0.3 0 0.1") + "</link>"
    fixed = '<joint name="nailed" type="fixed"><parent link="body"/><child link="bar"/></joint>'
    (place / "a.urdf").write_text(rubbing(0.01).replace("</robot>", bar + fixed + "</robot>"))
    import_folder(tmp_path / "mine", tmp_path / "models")
    assert re.search(r"a.urdf: drawer 'low' sticks at \d+ % of its range", capsys.readouterr().out)


def test_a_joint_that_is_slow_does_not_stick(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = tmp_path / "mine" / "chest_of_drawers" / "rubbing"
    place.mkdir(parents=True)
    (place / "a.urdf").write_text(rubbing(0.01))
    (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
    for damping in (600.0, 6000.0):  # 20 N: 3 cm/s, six seconds; or 3 mm/s, which are not over in time
        monkeypatch.setattr("roomkin.stages.simulation.loading.DAMPING", damping)
        assert stuck_joints(tmp_path / "models" / asset.id) == []


def test_a_heavy_door_is_pushed_at_its_free_edge(tmp_path: Path) -> None:
    """A fridge's door of 7 kg: half a hundred newton metres of weight on its hinge, and 14 of a hand."""
    weight = '<inertial><mass value="7"/><inertia ixx="0.6" iyy="0.4" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial>'
    door = box("0.03 0.7 0.8", "0 0.35 0") + box("0.03 0.02 0.3", "0.05 0.6 0")
    links = f'<link name="body">{box("0.02 0.7 1.6", "-0.3 0 0.8")}</link><link name="door">{weight}{door}</link>'
    place = tmp_path / "mine" / "fridge" / "heavy"
    place.mkdir(parents=True)
    hinge = joint("hinge", "revolute", "door", "0 0 -1", 1.5, "0.3 -0.35 0.5")
    (place / "a.urdf").write_text(f'<robot name="c">{links}{hinge}</robot>')
    (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
    assert [joint.part_type for joint in asset.joints] == ["door"] and asset.mass > 7
    assert stuck_joints(tmp_path / "models" / asset.id) == []


def write_partnet(folder: Path, number: str, text: str, category: str = "StorageFurniture") -> None:
    (folder / number).mkdir(parents=True)
    (folder / number / "mobility.urdf").write_text(text)
    (folder / number / "mobility_annotation_gapartnet.urdf").write_text(text)
    (folder / number / "meta.json").write_text(json.dumps({"model_cat": category, "anno_id": number}))
    (folder / number / "semantics.txt").write_text("link_0 hinge rotation_door\n")


def test_partnet_folders_are_read_as_they_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "partnet"
    write_partnet(mine, "45132", cabinet(180))
    write_partnet(mine, "45133", cabinet(180))
    write_partnet(mine, "12249", cabinet(180).replace('size="0.4 0.5 0.8"', 'size="0.5 0.5 0.8"'), "Refrigerator")
    write_partnet(mine, "99999", "<robot", "Chair")
    assets = import_folder(mine, tmp_path / "models")
    assert [(asset.id, asset.doors, asset.drawers) for asset in assets] == [
        ("fridge_12249", 1, 1),
        ("bottom_cabinet_45132", 1, 1),
        ("bottom_cabinet_45133", 1, 1),
    ]
    assert assets[1].checksum == assets[2].checksum, "a copy, which `join` leaves out"
    assert all(joint.handle for asset in assets for joint in asset.joints), "found, as the front faces +x"
    said = capsys.readouterr().out
    assert "left out: " in said and "99999" in said
    assert "turned to face +x, where 2 of its doors and drawers open" in said


@pytest.mark.parametrize(
    ("name", "category"),
    [
        ("025_mug", "mug"),
        ("IKEA-Sofa (1)", "sofa"),
        ("old plant pot", "plant_pot"),
        ("studyTable", "table"),
        ("hingeCabinet", "bottom_cabinet"),
        ("MUG2", "mug"),
        ("chairs", "chair"),
        ("gearbox", None),
        ("turntable", None),
        ("011_banana", None),
    ],
)
def test_a_name_may_tell_the_category(name: str, category: str | None) -> None:
    assert category_in(name) == category


def test_models_lie_anywhere_and_what_they_are_made_of_is_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path, text in {
        "hinge_cabinet.xml": "<mujoco><asset><mesh file='DOOR.stl'/></asset><worldbody/></mujoco>",
        "hinge_cabinet/meshes/door.stl": "",
        "hinge_cabinet/meshes/door_old.stl": "",
        "hinge_cabinet/body.xml": "<mujocoinclude/>",
        "025_mug/mug.urdf": '<robot><mesh filename="package://ycb/textured.obj"/></robot>',
        "025_mug/textured.obj": "",
        "025_mug/visual.obj": "",
        "011_banana/banana.urdf": "<robot/>",
        "Wooden Chair.glb": "",
        "downloads/lamp.glb": "",
        "downloads/gear.glb": "",
    }.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    found = {(one.category, one.name) for one in discover(tmp_path, [".urdf", ".xml", ".glb", ".obj", ".stl"])}
    assert found == {
        ("bottom_cabinet", "hinge_cabinet"),
        ("mug", "mug"),
        ("banana", "banana"),
        ("chair", "Wooden Chair"),
        ("table_lamp", "lamp"),
        ("gear", "gear"),
    }
    assert "5 files are parts" in capsys.readouterr().err


@pytest.mark.parametrize("turn", [0.0, 143.0, -30.0, 50.0])
def test_a_cabinet_that_stands_askew_in_its_file_is_turned(tmp_path: Path, turn: float) -> None:
    (tmp_path / "bottom_cabinet").mkdir()
    (tmp_path / "bottom_cabinet/c.urdf").write_text(cabinet(turn))
    (asset,) = import_folder(tmp_path, tmp_path / "library")
    assert {joint.part_type for joint in asset.joints} == {"door", "drawer"}
    assert asset.size == pytest.approx((0.445, 0.5, 0.86), abs=0.06)
