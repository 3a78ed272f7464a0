"""What an imported articulation is taken for: front, doors and drawers, masses; PartNet folders as they are."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from stages.articulated.asset_folder import read_model
from stages.articulated.forward_kinematics import link_frames
from stages.articulated.sense import doors_and_drawers, front_direction
from stages.articulated.urdf_reader import read_urdf
from stages.assets.discover import discover, numbered_names
from stages.assets.imports import import_folders
from stages.assets.pushing import stuck_joints
from stages.procedural.resize import resized

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
        "tray": box("0.3 0.3 0.02"),
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


def test_only_doors_and_drawers_move(tmp_path: Path) -> None:
    (tmp_path / "c.urdf").write_text(cabinet())
    robot, doubts = doors_and_drawers(read_urdf(tmp_path / "c.urdf", tmp_path))
    assert [joint.name for joint in robot.joints if joint.type != "fixed"] == ["hinge", "slide"]
    assert doubts == ["joints 'press', 'sideways', 'turn', 'helper' move no door or drawer: fixed"]
    before = link_frames(read_urdf(tmp_path / "c.urdf", tmp_path))
    after = link_frames(robot)
    assert all(np.allclose(before[name], after[name]) for name in before), "everything stays where it was, closed"


def test_unknown_masses_are_those_of_boards(tmp_path: Path) -> None:
    (tmp_path / "c.urdf").write_text(cabinet())
    links = read_urdf(tmp_path / "c.urdf", tmp_path).links
    assert 1.5 < links["door"].mass < 4, "a door of half a metre"
    assert links["drawer"].mass < 10 < 0.4 * 0.5 * 0.8 * 500
    assert 5 < links["body"].mass < 25, "a shell, not 80 kg of solid wood"


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
    (asset,) = import_folders([tmp_path / "mine"], tmp_path / "models")
    folder = tmp_path / "models" / asset.id
    assert list(read_model(folder).touching) == pairs
    assert (folder / "model.srdf").exists() == bool(pairs)
    sized = resized(folder, (0.5, 0.6, 0.7), tmp_path / "sized")
    assert list(read_model(sized).touching) == pairs
    assert stuck_joints(folder) == []


def test_a_joint_that_sticks_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / "mine" / "chest_of_drawers" / "barred"
    place.mkdir(parents=True)
    bar = '<link name="bar">' + box("0.02 0.6 0.2", "0.3 0 0.1") + "</link>"
    fixed = '<joint name="nailed" type="fixed"><parent link="body"/><child link="bar"/></joint>'
    (place / "a.urdf").write_text(rubbing(0.01).replace("</robot>", bar + fixed + "</robot>"))
    import_folders([tmp_path / "mine"], tmp_path / "models")
    assert re.search(r"a.urdf: drawer 'low' sticks at \d+ % of its range", capsys.readouterr().out)


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
    assets = import_folders([mine], tmp_path / "models")
    assert [(asset.id, asset.doors, asset.drawers) for asset in assets] == [
        ("fridge_12249", 1, 1),
        ("bottom_cabinet_45132", 1, 1),
    ]
    assert all(joint.handle for asset in assets for joint in asset.joints), "found, as the front faces +x"
    said = capsys.readouterr().out
    assert "45133/mobility.urdf: is a copy of bottom_cabinet_45132" in said
    assert "left out: " in said and "99999" in said
    assert "turned to face +x, where 2 of its doors and drawers open" in said


def test_names(tmp_path: Path) -> None:
    for path in (
        "chair/red/model.urdf",
        "chair/blue/a.urdf",
        "chair/blue/b.urdf",
        "chair/plain.urdf",
        "lamp/7/mobility.urdf",
    ):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text("")
    found = [(one.category, one.name) for one in discover(tmp_path, [".urdf"])]
    assert found == [("chair", "a"), ("chair", "b"), ("chair", "plain"), ("chair", "red"), ("lamp", "7")]
    assert numbered_names(["a", "a", "b", "a_2", "a"], ["b"]) == ["a", "a_2", "b_2", "a_2_2", "a_3"]
