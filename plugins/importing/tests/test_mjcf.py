"""MJCF by MuJoCo's compiled model: kinematics, what is seen and what collides, masses, files inside a folder."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.importing.discover import discover
from roomkin.plugins.importing.importers.mjcf import read_mjcf
from roomkin.plugins.importing.tests.own_models import import_folder
from roomkin.stages.articulated.model import link_frames
from roomkin.stages.geometry.frames import transform_points
from tests.refusals import refused

ASSETS = """<mujocoinclude><asset><texture name="wood" type="2d" file="common/wood.png"/>
<mesh name="block" file="parts/block.stl" scale="0.1 0.1 0.1"/><material name="oak" texture="wood"/></asset>
<default><default class="solid"><geom group="3" rgba="1 0 0 0.5"/></default>
<default class="seen"><geom group="1" contype="0" conaffinity="0"/></default></default></mujocoinclude>"""

CABINET = """<mujoco model="c"><compiler angle="degree" />
<include file="parts/assets.xml"/>
<actuator><position joint="slide"/></actuator>
<worldbody><light pos="0 0 3"/><geom type="plane" size="5 5 1"/>
<body name="body" pos="1 2 0.4" euler="0 0 90">
 <geom class="seen" type="box" size="0.2 0.25 0.4" rgba="0.2 0.4 0.6 1"/>
 <geom class="solid" type="box" size="0.2 0.25 0.4"/>
 <body name="door" pos="0.2 0 -0.15"><joint name="hinge" pos="0.01 -0.25 0" axis="0 0 1" range="-100 0"/>
  <geom class="seen" type="box" pos="0.01 0 0" size="0.01 0.25 0.2" material="oak"/>
  <geom class="solid" type="box" pos="0.01 0 0" size="0.01 0.25 0.2" mass="2"/>
  <body name="handle" pos="0.04 0.2 0"><geom class="seen" type="capsule" size="0.008 0.08"/></body></body>
 <body name="drawer" pos="0.2 0 0.25"><joint name="slide" type="slide" axis="1 0 0" range="0 0.25"/>
  <inertial mass="3" pos="-0.1 0 0" diaginertia="0.1 0.2 0.3"/>
  <geom class="seen" type="box" pos="0.01 0 0" size="0.01 0.25 0.1"/>
  <geom class="seen" type="mesh" mesh="block" pos="0.03 0 0"/></body>
 <body name="dial" pos="0.2 0.1 0.38"><joint name="turn" axis="1 0 0"/>
  <geom class="seen" type="cylinder" size="0.02 0.01"/></body>
</body></worldbody></mujoco>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """<folder>/bottom_cabinet/oak.xml with its parts beside it; the package has been renamed since."""
    place = tmp_path / "mine" / "bottom_cabinet"
    (place / "parts").mkdir(parents=True)
    (place / "common").mkdir()
    (place / "oak.xml").write_text(CABINET)
    (place / "parts/assets.xml").write_text(ASSETS)
    trimesh.creation.box((0.2, 2, 0.2)).export(place / "parts/block.stl")
    Image.new("RGB", (4, 4), (128, 64, 0)).save(place / "common/wood.png")
    return tmp_path / "mine"


def test_links_are_where_mujoco_has_them(folder: Path) -> None:
    robot = read_mjcf(folder / "bottom_cabinet/oak.xml", folder)
    assert [(joint.name, joint.type) for joint in robot.joints if joint.type != "fixed"] == [
        ("hinge", "revolute"),
        ("slide", "prismatic"),
    ]
    text = CABINET.replace('<include file="parts/assets.xml"/>', "").replace('material="oak"', "")
    for name in ("seen", "solid"):
        text = text.replace(f'class="{name}"', "")
    model = mujoco.MjModel.from_xml_string(text.replace('type="mesh" mesh="block"', 'size="0.1"'))
    data = mujoco.MjData(model)
    for share, angle, slide in ((0.0, 0.0, 0.0), (0.5, -50.0, 0.125), (1.0, -100.0, 0.25)):
        data.joint("hinge").qpos[0], data.joint("slide").qpos[0] = np.deg2rad(angle), slide
        mujoco.mj_kinematics(model, data)
        frames = link_frames(robot, share)
        for body in ("body", "door", "drawer", "handle"):
            first = int(model.body(body).geomadr[0])
            center = robot.links[body].visuals[0].mesh.bounds.mean(axis=0)
            assert transform_points(frames[body], center) == pytest.approx(data.geom_xpos[first], abs=1e-6), (
                body,
                share,
            )


def test_looks_masses_and_what_collides(folder: Path) -> None:
    links = read_mjcf(folder / "bottom_cabinet/oak.xml", folder).links
    assert links["world"].visuals == [], "the ground is none of it"
    assert links["body"].visuals[0].color == pytest.approx((0.2, 0.4, 0.6, 1.0))
    assert len(links["body"].visuals) == len(links["body"].collisions) == 1, "seen and solid are not mixed"
    assert links["door"].visuals[0].color == pytest.approx((0.22, 0.048, 0, 1), abs=0.01), "its texture's mean, linear"
    assert links["drawer"].visuals[1].mesh.extents == pytest.approx((0.02, 0.2, 0.02))
    assert (links["door"].mass, links["door"].weighed) == (2.0, True)
    assert (links["drawer"].mass, links["drawer"].center.tolist()) == (3.0, [-0.1, 0, 0])
    assert np.allclose(links["drawer"].inertia, np.diag([0.1, 0.2, 0.3]))
    assert not links["body"].weighed
    assert links["body"].mass < 15, "boards, not 160 kg of water"


def test_a_model_is_imported_whole_and_its_parts_are_not(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (asset,) = import_folder(folder, folder.parent / "models")
    assert (asset.id, asset.doors, asset.drawers) == ("bottom_cabinet_oak", 1, 1)
    assert asset.size == pytest.approx((0.448, 0.5, 0.8), abs=2e-3)
    assert [joint.handle is not None for joint in asset.joints] == [True, True]
    said = "".join(capsys.readouterr())
    assert "1 files are parts that other models include" in said
    assert "block" not in said
    (folder / "bottom_cabinet/package.xml").write_text("<package/>")
    assert len(discover(folder, [".xml", ".stl"])) == 1, "other XML is no model"


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("parts/assets.xml", "../../secret.xml", "E-FILE-OUTSIDE"),
        ("parts/block.stl", "../../../secret.stl", "E-FILE-OUTSIDE"),
        ("parts/assets.xml", "oak.xml", "E-MJCF-REFUSED"),
        ("</worldbody></mujoco>", "", "E-XML-BROKEN"),
        ('size="0.02 0.01"', 'size="-1"', "E-MJCF-REFUSED"),
        ("<mujoco model", "<!DOCTYPE a><mujoco model", "E-XML-DOCTYPE"),
        ("</worldbody>", "<body><freejoint/><geom size='1'/></body>" * 2 + "</worldbody>", "E-MJCF-SCENE"),
    ],
)
def test_broken_files_are_one_line(folder: Path, old: str, new: str, code: str) -> None:
    (folder.parent / "secret.xml").write_text(ASSETS)
    (folder.parent / "secret.stl").write_text("")
    path, parts = folder / "bottom_cabinet/oak.xml", folder / "bottom_cabinet/parts/assets.xml"
    path.write_text(CABINET.replace(old, new))
    parts.write_text(ASSETS.replace(old, new))
    with refused(code) as told:
        read_mjcf(path, folder)
    assert "\n" not in str(told.value)


def test_textures_of_meshes_stay_upright(tmp_path: Path) -> None:
    picture = np.zeros((8, 8, 3), np.uint8)
    picture[:4], picture[4:] = (255, 0, 0), (0, 0, 255)
    Image.fromarray(picture).save(tmp_path / "t.png")
    corners = "v 0 0 0\nv 0 1 0\nv 0 1 1\nv 1 0 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
    (tmp_path / "m.obj").write_text(f"{corners}f 1/1 2/2 3/3\nf 4/1 3/3 2/2\nf 4/1 2/2 1/1\nf 4/1 1/1 3/3\n")
    (tmp_path / "t.xml").write_text(
        '<mujoco><asset><texture name="t" type="2d" file="t.png"/><material name="t" texture="t"/><mesh name="m" '
        'file="m.obj"/></asset><worldbody><body><geom type="mesh" mesh="m" material="t"/></body></worldbody></mujoco>'
    )
    robot = read_mjcf(tmp_path / "t.xml", tmp_path)
    (visual,) = robot.links["body_1"].visuals
    colors = visual.mesh.visual.to_color().vertex_colors
    top = visual.mesh.vertices[:, 2] > 0.9
    assert top.any()
    assert (colors[top, 0] > 200).all() and (colors[~top, 2] > 200).all()


def test_a_geoms_own_color_beats_its_materials_and_textures_without_a_place_are_told(tmp_path: Path) -> None:
    Image.fromarray(np.kron([[0, 255], [255, 0]], np.ones((2, 2))).astype(np.uint8)).save(tmp_path / "t.png")
    (tmp_path / "t.xml").write_text(
        '<mujoco><asset><texture name="t" type="2d" file="t.png"/><texture name="f" type="2d" builtin="flat" width="4" '
        'height="4" rgb1="1 0 0"/><material name="checked" texture="t"/><material name="even" texture="f"/>'
        '<material name="blue" rgba="0 0 1 1"/></asset><worldbody><body>'
        '<geom size="1" material="blue"/><geom size="1" material="blue" rgba="0 1 0 1"/><geom size="1"/>'
        '<geom size="1" material="even"/><geom size="1" material="checked"/></body></worldbody></mujoco>'
    )
    robot = read_mjcf(tmp_path / "t.xml", tmp_path)
    colors = [visual.color for visual in robot.links["body_1"].visuals]
    assert colors[:4] == [(0, 0, 1, 1), (0, 1, 0, 1), (0.5, 0.5, 0.5, 1), (1, 0, 0, 1)]
    assert robot.remarks == ("shown in the mean color of their textures, which no mesh places: materials 'checked'",)


def test_what_is_fixed_or_left_out_is_named(folder: Path) -> None:
    path = folder / "bottom_cabinet/oak.xml"
    path.write_text(CABINET.replace("</mujoco>", '<equality><weld body1="door"/></equality></mujoco>'))
    assert read_mjcf(path, folder).remarks == (
        "fixed: 1 joints ('turn'), which have no limits or turn as balls do",
        "has what is not read: 1 equality constraints",
    )


BOX = '<geom type="box" size=".1 .1 .1"/>'


def _write(folder: Path, text: str) -> Path:
    (folder / "a.xml").write_text(f"<mujoco>{text}</mujoco>")
    return folder / "a.xml"


@pytest.mark.parametrize(
    ("inside", "before", "said"),
    [
        ("<region/>", "", "unrecognized element"),
        ('<joint name="j" axis="0 0 0"/>', "", "axis"),
        ("", '<asset><material name="m"/><material name="m"/></asset>', "repeated name 'm'"),
    ],
)
def test_what_mujoco_refuses_is_told_in_its_words(tmp_path: Path, inside: str, before: str, said: str) -> None:
    path = _write(tmp_path, f"{before}<worldbody><body>{inside}{BOX}</body></worldbody>")
    with refused("E-MJCF-REFUSED") as told:
        read_mjcf(path, tmp_path)
    assert said in str(told.value) and "\n" not in str(told.value)


def test_a_range_counts_where_it_need_not_hold_if_it_ends_closed(tmp_path: Path) -> None:
    for told, moves in (("0 2.7", True), ("-1.5 0", True), ("-10.3 10.3", False)):
        turns = f'<body><joint name="j" axis="0 0 1" limited="false" range="{told}"/>{BOX}</body>'
        text = f'<compiler angle="radian"/><worldbody>{turns}</worldbody>'
        robot = read_mjcf(_write(tmp_path, text), tmp_path)
        assert (robot.joints[0].type == "revolute") == moves
