"""Doors that follow one another: both open, in the file that is written, in SAPIEN and in MuJoCo; others are named."""

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest
import sapien
from sapien.physx import PhysxArticulation

from roomkin.plugins.importing.importers.mjcf import read_mjcf
from roomkin.plugins.mujoco.mjcf_writer import document
from roomkin.stages.articulated.asset_folder import Description, assign_part_types, read_model, write_asset
from roomkin.stages.articulated.model import RobotModel, link_frames
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.simulation.loading import load_asset, physics_scene

LIMIT = '<limit lower="0" upper="1.6"/>'
PAIR = """<robot name="pair">
<link name="body"><visual><origin xyz="0 0 0.4"/><geometry><box size="0.4 0.8 0.8"/></geometry></visual></link>
<link name="right"><visual><origin xyz="0.01 -0.19 0"/><geometry><box size="0.02 0.38 0.7"/></geometry></visual></link>
<link name="left"><visual><origin xyz="0.01 0.19 0"/><geometry><box size="0.02 0.38 0.7"/></geometry></visual></link>
<joint name="leads" type="revolute"><parent link="body"/><child link="right"/><origin xyz="0.2 0.4 0.4"/>
<axis xyz="0 0 1"/><limit lower="0" upper="1.6"/></joint>
<joint name="follows" type="revolute"><parent link="body"/><child link="left"/><origin xyz="0.2 -0.4 0.4"/>
<axis xyz="0 0 -1"/><limit lower="0" upper="1.6"/><mimic joint="leads"/></joint></robot>"""


def read(folder: Path, text: str) -> RobotModel:
    folder.mkdir(exist_ok=True)
    (folder / "a.urdf").write_text(text)
    return read_urdf(folder / "a.urdf", folder)


@pytest.mark.parametrize(
    ("axis", "mimic"),
    [
        ('"0 0 -1"', 'joint="leads"'),
        ('"0 0 1"', 'joint="leads" multiplier="-1"'),
        ('"0 0 1"', 'multiplier="-1" joint="leads" offset="0"'),
    ],
)
def test_a_second_leaf_opens_as_far_as_the_first(tmp_path: Path, axis: str, mimic: str) -> None:
    text = PAIR.replace('"0 0 -1"', axis).replace('<mimic joint="leads"/>', f"<mimic {mimic}/>")
    robot = read(tmp_path, text)
    assert [(joint.name, joint.follows, joint.upper) for joint in robot.joints] == [
        ("leads", None, 1.6),
        ("follows", "leads", 1.6),
    ]
    for share in (0.0, 0.5, 1.0):
        right, left = (link_frames(robot, share)[name] for name in ("right", "left"))
        mirror = np.diag([1.0, -1.0, 1.0])
        assert left[:3, :3] == pytest.approx(mirror @ right[:3, :3] @ mirror, abs=1e-9), "they swing to both sides"
    assert not robot.remarks


def test_an_offset_turns_the_zero_of_what_follows(tmp_path: Path) -> None:
    robot = read(tmp_path, PAIR.replace('<mimic joint="leads"/>', '<mimic joint="leads" offset="0.3"/>'))
    joint = robot.joints[1]
    assert (joint.lower, joint.upper) == (0.0, 1.6)
    assert joint.origin[:3, :3] @ [1, 0, 0] == pytest.approx([np.cos(0.3), -np.sin(0.3), 0])


def test_an_offset_is_about_the_axis_that_the_file_says(tmp_path: Path) -> None:
    """A leaf that turns the other way: its own value is 0.3 less the leader's."""
    mirrored = '<mimic joint="leads" multiplier="-1" offset="0.3"/>'
    robot = read(tmp_path, PAIR.replace('"0 0 -1"', '"0 0 1"').replace('<mimic joint="leads"/>', mirrored))
    joint = robot.joints[1]
    for leads in (0.0, 0.5):
        turn = 0.3 - leads
        assert (joint.origin @ joint.motion(leads))[:3, 0] == pytest.approx([np.cos(turn), np.sin(turn), 0])


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            '<mimic joint="leads"/>',
            '<mimic joint="leads" multiplier="2"/>',
            "fixed: 'follows', which follows 2 times 'leads'",
        ),
        ('<mimic joint="leads"/>', '<mimic joint="gone"/>', "fixed: 'follows', which follows 1 times 'gone'"),
        ('name="follows" type="revolute"', 'name="follows" type="prismatic"', "fixed: 'follows'"),
        ('name="leads" type="revolute"', 'name="leads" type="continuous"', "no door or drawer: 'leads' (continuous)"),
        ('name="follows" type="revolute"', 'name="follows" type="floating"', "drawer: 'follows' (floating)"),
        ('name="follows" type="revolute"', 'name="follows" type="planar"', "drawer: 'follows' (planar)"),
    ],
)
def test_what_cannot_move_is_fixed_and_named(tmp_path: Path, old: str, new: str, says: str) -> None:
    robot = read(tmp_path, PAIR.replace(old, new))
    assert any(says in line for line in robot.remarks)
    assert robot.joints[1].type == "fixed"


def test_both_leaves_open_in_both_simulators(tmp_path: Path) -> None:
    robot = assign_part_types(read(tmp_path / "theirs", PAIR))
    asset = write_asset(robot, tmp_path / "pair", Description("pair", "wall_cabinet", "none", "test"))
    assert asset.doors == 2
    scene = physics_scene()
    body = load_asset(scene, tmp_path / "pair", sapien.Pose(), fixed=True, name="pair")
    assert isinstance(body, PhysxArticulation)
    names = [joint.name for joint in body.get_active_joints()]
    push = np.array([20.0 * (name == "leads") for name in names], np.float32)
    for _ in range(100):
        body.set_qf(push)
        scene.step()
    one, other = body.get_qpos()
    assert one == pytest.approx(other, abs=0.03)
    assert one > 0.5

    written = read_model(tmp_path / "pair")
    assert [joint.follows for joint in written.joints] == [None, "leads"]
    with document(tmp_path / "scene", "pair") as (root, writer):
        writer.model(ET.SubElement(root, "worldbody"), "pair", written, np.eye(4), fixed=True)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene/scene.xml"))
    data = mujoco.MjData(model)
    data.qfrc_applied[model.joint("pair/leads").dofadr[0]] = 5.0
    mujoco.mj_step(model, data, 500)
    assert data.joint("pair/leads").qpos[0] > 0.5
    assert data.joint("pair/leads").qpos[0] == pytest.approx(data.joint("pair/follows").qpos[0], abs=0.03)


MJCF = """<mujoco><compiler angle="radian"/><worldbody><body><geom type="box" size="0.2 0.4 0.4"/>
<body pos="0.2 0.4 0"><joint name="leads" axis="0 0 1" range="0 1.6"/>
<geom type="box" pos="0.01 -0.19 0" size="0.01 0.19 0.3"/></body>
<body pos="0.2 -0.4 0"><joint name="follows" axis="0 0 -1" range="0 1.6"/>
<geom type="box" pos="0.01 0.19 0" size="0.01 0.19 0.3"/></body></body></worldbody>
<equality><joint joint1="follows" joint2="leads"/></equality></mujoco>"""


def test_mjcf_says_the_same_by_an_equality(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(MJCF)
    robot = read_mjcf(tmp_path / "a.xml", tmp_path)
    assert {joint.name: joint.follows for joint in robot.joints if joint.type != "fixed"} == {
        "leads": None,
        "follows": "leads",
    }
    assert not robot.remarks
    mirrored = MJCF.replace('axis="0 0 -1" range="0 1.6"', 'axis="0 0 1" range="-1.6 0"')
    (tmp_path / "a.xml").write_text(mirrored.replace('joint2="leads"', 'joint2="leads" polycoef="0 -1 0 0 0"'))
    joint = next(one for one in read_mjcf(tmp_path / "a.xml", tmp_path).joints if one.name == "follows")
    assert (joint.follows, joint.lower, joint.upper, joint.axis.tolist()) == ("leads", 0.0, 1.6, [0, 0, -1])
    (tmp_path / "a.xml").write_text(MJCF.replace('joint2="leads"', 'joint2="leads" polycoef="0 2 0 0 0"'))
    assert read_mjcf(tmp_path / "a.xml", tmp_path).remarks == ("has what is not read: 1 equality constraints",)
