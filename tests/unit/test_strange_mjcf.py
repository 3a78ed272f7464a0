"""MJCF as packs of other people have it: parts of simulations, made for older versions, without their textures."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from stages.assets.importers.mjcf import read_mjcf
from stages.contracts.errors import InputError
from tests.unit.test_strange_packs import mjcf

pytest.importorskip("mujoco")


def test_a_texture_that_is_missing_is_grey(tmp_path: Path) -> None:
    looks = '<texture type="cube" file="../textures/oak.png"/><material name="m" texture="oak"/>'
    thing = '<worldbody><geom type="box" size=".1 .1 .1" material="m"/></worldbody>'
    robot = read_mjcf(mjcf(tmp_path / "a.xml", f"<asset>{looks}</asset>{thing}"), tmp_path)
    (visual,) = robot.links["world"].visuals
    assert visual.colour is not None
    assert len(set(visual.colour[:3])) == 1 and visual.colour[0] < 1
    assert robot.remarks[0].startswith("grey in place of a texture: there is no file '../textures/oak.png'")


def test_defaults_of_older_mujoco(tmp_path: Path) -> None:
    red = '<default class="red"><geom rgba="1 0 0 1"/></default>'
    defaults = f'<default class="base"><geom rgba="0 1 0 1"/>{red}</default>'
    geoms = "".join(f'<geom type="box" size=".1 .1 .1" {told}/>' for told in ("", 'class="base"', 'class="red"'))
    robot = read_mjcf(mjcf(tmp_path / "a.xml", f"{defaults}<worldbody>{geoms}</worldbody>"), tmp_path)
    assert [visual.colour[:3] for visual in robot.links["world"].visuals if visual.colour] == [
        (0, 1, 0),
        (0, 1, 0),
        (1, 0, 0),
    ]


TABLE = '<worldbody><body name="table" pos="0 0 -1"><geom type="box" size="1 1 1"/></body></worldbody>'


def test_what_is_included_around_a_thing_is_no_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(f"<mujocoinclude>{TABLE}</mujocoinclude>")
    thing = '<worldbody><body name="cup"><geom type="box" size=".05 .05 .05"/></body></worldbody>'
    robot = read_mjcf(mjcf(tmp_path / "cup.xml", f'<include file="scene.xml"/>{thing}'), tmp_path)
    assert "cup" in robot.links and "table" not in robot.links
    assert robot.remarks == ("left out, as included around it: 'table'",)
    floor = '<worldbody><geom type="plane" size="1 1 1"/></worldbody>'
    robot = read_mjcf(mjcf(tmp_path / "whole.xml", f'<include file="scene.xml"/>{floor}'), tmp_path)
    assert "table" in robot.links and not robot.remarks, "the included file is the model"


@pytest.mark.parametrize(
    ("compiler", "upper", "expected"),
    [("", "1.5", 1.5), ("", "90", np.pi / 2), ('<compiler angle="degree"/>', "1.5", np.deg2rad(1.5))],
)
def test_hinges_of_a_few_units_turn_by_radians(tmp_path: Path, compiler: str, upper: str, expected: float) -> None:
    hinge = f'<joint name="j" axis="0 0 1" limited="true" range="0 {upper}"/>'
    turns = f'<body>{hinge}<geom type="box" size=".1 .1 .1"/></body>'
    robot = read_mjcf(mjcf(tmp_path / "a.xml", f"{compiler}<worldbody>{turns}</worldbody>"), tmp_path)
    assert robot.joints[0].upper == pytest.approx(expected)


BOX = '<geom type="box" size=".1 .1 .1"/>'
MENDED = [
    ('<joint name="j" range="1 -.5"/>', "", "joint 'j': limits upside down (1, -0.5)"),
    ('<joint name="j" axis="0 0 0"/>', "", "joint 'j': its axis is zero. It is fixed."),
    ("<region/>", "", "left out: <region>, which MuJoCo does not know"),
    (BOX.replace("/>", ' cooking="1"/>'), "", "left out: cooking of <geom>"),
    (BOX.replace("/>", ' material="oak"/>'), "", "grey in place of material 'oak'"),
    ("", '<asset><material name="m"/><material name="m"/></asset>', "left out: another material 'm'"),
    ('<inertial mass="1"/>', "", "left out: an <inertial>"),
    ('<joint type="fixed"/>', "", "left out: joints called fixed"),
    ('<joint range="0 1"/>', '<compiler inertiagrouprange="4 4"/>', "are weighed by all"),
]


@pytest.mark.parametrize(("inside", "before", "said"), MENDED)
def test_what_a_model_can_do_without_is_left_out(tmp_path: Path, inside: str, before: str, said: str) -> None:
    text = f"{before}<worldbody><body>{inside}{BOX}</body></worldbody>"
    robot = read_mjcf(mjcf(tmp_path / "a.xml", text), tmp_path)
    assert [said in remark for remark in robot.remarks].count(True) == 1
    assert any(link.visuals for link in robot.links.values())


def test_two_bodies_of_one_name_are_still_refused(tmp_path: Path) -> None:
    bodies = 2 * f'<body name="a">{BOX}</body>'
    with pytest.raises(InputError, match=r"MuJoCo does not take it: .*repeated name 'a' in body"):
        read_mjcf(mjcf(tmp_path / "a.xml", f"<worldbody>{bodies}</worldbody>"), tmp_path)


def test_textures_may_be_jpeg_and_what_is_no_picture_is_grey(tmp_path: Path) -> None:
    Image.new("RGB", (8, 8), (200, 0, 0)).save(tmp_path / "red.jpg")
    (tmp_path / "red.obj").write_text("no picture")
    thing = '<worldbody><geom type="box" size=".1 .1 .1" material="m"/></worldbody>'
    for name, red, said in (("red.jpg", True, 0), ("red.obj", False, 1)):
        looks = f'<texture name="t" type="2d" file="{name}"/><material name="m" texture="t"/>'
        robot = read_mjcf(mjcf(tmp_path / "a.xml", f"<asset>{looks}</asset>{thing}"), tmp_path)
        (visual,) = robot.links["world"].visuals
        assert visual.colour is not None and (visual.colour[0] > 2 * visual.colour[1]) == red
        assert len(robot.remarks) == said


def test_one_mesh_of_many_may_be_missing(tmp_path: Path) -> None:
    for name in "abcd":
        trimesh.creation.box().export(tmp_path / f"{name}.stl")
    meshes = "".join(f'<mesh file="{name}.stl"/>' for name in "abcd")
    geoms = "".join(f'<geom type="mesh" mesh="{name}"/>' for name in "abcd")
    path = mjcf(tmp_path / "a.xml", f"<asset>{meshes}</asset><worldbody>{geoms}</worldbody>")
    (tmp_path / "b.stl").unlink()
    robot = read_mjcf(path, tmp_path)
    assert len(robot.links["world"].visuals) == 3
    assert robot.remarks[0].startswith("left out: mesh 'b': there is no file 'b.stl'")
    (tmp_path / "c.stl").unlink()
    with pytest.raises(InputError, match=r"there is no file 'b.stl'"):
        read_mjcf(path, tmp_path)


def test_a_range_counts_where_it_need_not_hold_if_it_ends_closed(tmp_path: Path) -> None:
    for told, moves in (("0 2.7", True), ("-1.5 0", True), ("-10.3 10.3", False)):
        turns = f'<body><joint name="j" axis="0 0 1" limited="false" range="{told}"/>{BOX}</body>'
        text = f'<compiler angle="radian"/><worldbody>{turns}</worldbody>'
        robot = read_mjcf(mjcf(tmp_path / "a.xml", text), tmp_path)
        assert (robot.joints[0].type == "revolute") == moves
