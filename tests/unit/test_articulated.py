"""The articulated model: inertia, panels, roles, and that no room without a simulator imports one."""

import ast
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from roomkin.plugins.furniture.fronts import STYLES, Style
from roomkin.stages.articulated.affordance import handle_extents
from roomkin.stages.articulated.asset_folder import (
    Description,
    assign_part_types,
    atomic_folder,
    contract_joints,
    read_asset,
    read_model,
    write_asset,
)
from roomkin.stages.articulated.handle import find_handle, merge_visuals
from roomkin.stages.articulated.mesh_reader import texture_of
from roomkin.stages.articulated.model import (
    Link,
    RobotModel,
    Texture,
    Visual,
    change_root,
    link_frames,
    measure_closed_box,
)
from roomkin.stages.articulated.resizing import resize_model, stretch_model
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.articulated.urdf_tree import UrdfTree
from roomkin.stages.articulated.urdf_writer import write_urdf
from roomkin.stages.config.code import closure, source
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import make_transform
from tests.unit.articulated_models import CABINET, textured_box, write_cabinet
from tests.unit.demo_assets import cabinet

ABOUT = Description("cab", "bottom_cabinet", "CC0-1.0", "test")
NO_SIMULATOR = [
    "articulated",
    "config",
    "contracts",
    "extraction",
    "geometry",
    "matching",
    "roomkin.plugins.furniture",
]
SIMULATORS = {"sapien", "mani_skill", "gymnasium"}


def read(tmp_path: Path, text: str) -> RobotModel:
    (tmp_path / "a.urdf").write_text(text)
    return read_urdf(tmp_path / "a.urdf", tmp_path)


@pytest.mark.parametrize(
    ("inertial", "weighed"),
    [("", False), ("<inertial/>", False), ('<mass value="0.001"/>', False), ('<mass value="2"/>', True)],
)
def test_a_mass_is_stated_or_estimated(tmp_path: Path, inertial: str, weighed: bool) -> None:
    said = f"<inertial>{inertial}</inertial>" if "mass" in inertial else inertial
    shape = '<collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>'
    link = read(tmp_path, f'<robot name="r"><link name="a">{said}{shape}</link></robot>').links["a"]
    assert link.weighed == weighed and (link.mass == 2) == weighed


def test_inertia_of_a_turned_tensor_reaches_the_written_file(tmp_path: Path) -> None:
    rpy = np.array([0.3, -0.5, 0.7])
    own = np.diag([0.5, 0.4, 0.2])
    robot = read(
        tmp_path,
        '<robot name="r"><link name="body"><inertial><mass value="7"/><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.5 0.7"/>'
        '<inertia ixx="0.5" ixy="0" ixz="0" iyy="0.4" iyz="0" izz="0.2"/></inertial>'
        '<visual><geometry><box size="1 1 1"/></geometry></visual></link></robot>',
    )
    turn = Rotation.from_euler("xyz", rpy).as_matrix()
    body = robot.links["body"]
    assert (body.mass, body.center.tolist()) == (7.0, [0.1, 0.2, 0.3])
    assert np.allclose(body.inertia, turn @ own @ turn.T)
    assert not np.allclose(body.inertia, own, atol=0.01), "a tensor that is not turned would show"
    write_urdf(robot, tmp_path / "written")
    again = read_urdf(tmp_path / "written" / "model.urdf", tmp_path).links["body"]
    assert np.allclose(again.inertia, body.inertia, rtol=1e-4)
    assert (again.mass, again.center.tolist()) == (7.0, [0.1, 0.2, 0.3])
    quarter = Rotation.from_euler("z", np.pi / 2).as_matrix()
    turned = change_root(robot, make_transform(quarter, np.zeros(3))).links["body"]
    assert np.allclose(turned.inertia, quarter @ body.inertia @ quarter.T)
    assert np.allclose(turned.center, [-0.2, 0.1, 0.3])


BOARDS = 500 * 0.018 * (0.2 * 0.3 + 0.2 * 0.4 + 0.3 * 0.4)  # kg: half of the area of a box, 18 mm thick


def test_a_link_without_mass_weighs_boards_spread_as_in_a_solid_box(tmp_path: Path) -> None:
    robot = read(
        tmp_path,
        '<robot name="r"><link name="body"><visual><origin xyz="0 0 1"/><geometry><box size="0.2 0.3 0.4"/></geometry>'
        "</visual></link></robot>",
    )
    body = robot.links["body"]
    assert body.mass == pytest.approx(BOARDS)
    assert np.allclose(body.center, [0, 0, 1])
    assert np.allclose(body.inertia, BOARDS / 12 * np.diag([0.25, 0.20, 0.13]), atol=2e-7)


def test_rigid_meshes_have_the_inertia_of_their_hull(tmp_path: Path) -> None:
    from roomkin.plugins.importing.single_body import read_mesh

    trimesh.creation.box([0.2, 0.3, 0.4]).export(tmp_path / "box.obj")
    base = read_mesh(tmp_path / "box.obj", tmp_path).links["base"]
    assert base.mass == pytest.approx(BOARDS)
    assert np.allclose(base.inertia, BOARDS / 12 * np.diag([0.25, 0.20, 0.13]), atol=2e-7)


def test_a_mass_told_by_hand_scales_mass_and_inertia_of_every_link(tmp_path: Path) -> None:
    from roomkin.plugins.importing.repairs import with_mass

    robot = read_urdf(write_cabinet(tmp_path), tmp_path)
    heavy = with_mass(robot, 3 * robot.mass)
    assert heavy.mass == pytest.approx(3 * robot.mass)
    for name, link in heavy.links.items():
        assert link.mass == pytest.approx(3 * robot.links[name].mass)
        assert np.allclose(link.inertia, 3 * robot.links[name].inertia)


def test_fronts_are_measured_with_what_is_fixed_to_them(tmp_path: Path) -> None:
    robot = assign_part_types(read_urdf(write_cabinet(tmp_path), tmp_path))
    asset = write_asset(robot, tmp_path / "cab", ABOUT)
    door, drawer = asset.joints
    assert door.panel is not None and drawer.panel is not None
    assert door.panel.size == pytest.approx((0.58, 0.7), rel=1e-3), "the knob lies before the panel"
    assert door.panel.height == pytest.approx(0.4 - asset.box_min[2], abs=1e-4)
    assert {panel.kind for panel in asset.panels} == {"door", "drawer"}
    assert drawer.panel.size == pytest.approx((0.1, 0.05), rel=1e-3)
    assert (door.panel.hinge, drawer.panel.hinge) == ("right", "slide"), "turned round to close at 0"
    assert (door.handle, door.handle_link) == ("knob", "door_knob")
    assert (drawer.handle, drawer.handle_link) == (None, None), "nothing stands out of it"
    # a joint that moves nothing to be seen has no front
    door_link = robot.links["door"]
    bare = robot.links | {name: replace(robot.links[name], visuals=[]) for name in ("door", "door_knob")}
    assert door_link.visuals
    joints = contract_joints(replace(robot, links=bare))
    assert [joint.panel is None for joint in joints] == [True, False] and joints[0].handle is None
    askew = [replace(joint, axis=np.array([1.0, 2.0, 2.0]) / 3) for joint in robot.joints]
    (axis, *_) = {joint.axis for joint in contract_joints(replace(robot, joints=askew))}
    assert axis == (0.333333333, 0.666666667, 0.666666667)


@pytest.mark.parametrize("style", ["bar", "square_bar", "arch", "knob", "edge", "none"])
@pytest.mark.parametrize("cell", ["door", "drawer"])
def test_handles_are_told_from_their_shape(style: Style, cell: str, tmp_path: Path) -> None:
    """What the generator says of its handles is what a measurement says of the same shapes without a description."""
    told = cabinet(tmp_path / "cab", layout=[[cell]], handle=style, protrusion=STYLES[style].protrusion)
    robot = read_urdf(tmp_path / "cab" / "model.urdf", tmp_path / "cab")
    (measured,) = contract_joints(assign_part_types(robot))
    assert (measured.handle, measured.panel) == (told.joints[0].handle, told.joints[0].panel)
    assert told.joints[0].handle == STYLES[style].kind


@pytest.mark.parametrize(("hinge", "side"), [(1, "right"), (-1, "left")])
def test_hinge_sides_are_those_seen_from_the_front(hinge: int, side: str, tmp_path: Path) -> None:
    (joint,) = cabinet(tmp_path / "cab", hinge=hinge).joints
    assert joint.panel is not None and joint.panel.hinge == side
    (flap,) = cabinet(tmp_path / "oven", layout=[["flap"]]).joints
    assert flap.panel is not None and flap.panel.hinge == "bottom"


def test_an_assets_urdf_lies_in_its_folder(tmp_path: Path) -> None:
    write_asset(
        assign_part_types(read_urdf(write_cabinet(tmp_path / "mine"), tmp_path / "mine")), tmp_path / "cab", ABOUT
    )
    about = json.loads((tmp_path / "cab" / "asset.json").read_text()) | {
        "urdf": "../mine/bottom_cabinet/Oak 1/cab.urdf"
    }
    (tmp_path / "cab" / "asset.json").write_text(json.dumps(about))
    with pytest.raises(InputError, match=r"asset\.json: .*urdf"):
        read_model(tmp_path / "cab")


def test_a_folder_that_fails_while_it_is_written_leaves_the_old_one(tmp_path: Path) -> None:
    (tmp_path / "cab").mkdir()
    (tmp_path / "cab" / "notes.txt").write_text("mine")
    with pytest.raises(RuntimeError), atomic_folder(tmp_path / "cab") as folder:
        (folder / "model.urdf").touch()
        raise RuntimeError
    assert [path.relative_to(tmp_path).as_posix() for path in sorted(tmp_path.rglob("*"))] == ["cab", "cab/notes.txt"]


def test_roles_and_handles_survive_stretching(tmp_path: Path) -> None:
    asset = write_asset(assign_part_types(read_urdf(write_cabinet(tmp_path), tmp_path)), tmp_path / "cab", ABOUT)
    told = json.loads((tmp_path / "cab" / "asset.json").read_text())
    told["joints"][1] |= {"handle_link": "tray", "handle": "edge"}
    (tmp_path / "cab" / "asset.json").write_text(json.dumps(told))
    cab = tmp_path / "cab"
    robot, about = resize_model(cab, read_asset(cab), (0.45, 1.2, 0.925), by_recipe=False)
    wide = write_asset(robot, tmp_path / "wide", about)
    assert [(joint.name, joint.part_type, joint.handle_link, joint.handle) for joint in wide.joints] == [
        ("hinge", "door", "door_knob", "knob"),
        ("slide", "drawer", "tray", "edge"),
    ]
    assert (wide.doors, wide.drawers) == (asset.doors, asset.drawers) == (1, 1)
    assert wide.size == pytest.approx((0.45, 1.2, 0.925), abs=1e-5)


def test_colors_are_kept_exactly_and_looks_of_their_own_too(tmp_path: Path) -> None:
    painted = trimesh.creation.box([0.1, 0.1, 0.1])
    painted.visual.vertex_colors = [10, 200, 30, 255]
    plain = trimesh.creation.icosphere(1, 0.2)
    link = Link(
        "Body 1", [Visual(plain, (0.351, 0.2, 0.1, 1.0)), Visual(painted)], [plain], 1.0, np.zeros(3), np.eye(3)
    )
    write_urdf(RobotModel("r", {"Body 1": link}), tmp_path)
    assert sorted(path.name for path in (tmp_path / "meshes").iterdir()) == [
        "link_0.glb", "link_0_0.obj", "link_0_hull_0.obj"
    ]  # fmt: skip
    colored, own = read_urdf(tmp_path / "model.urdf", tmp_path).links["Body 1"].visuals
    assert colored.color == (0.351, 0.2, 0.1, 1.0)
    assert own.color is None
    picture = texture_of(own.paint())
    assert picture is not None
    assert np.asarray(picture).tolist() == [[[10, 200, 30, 255]]], "what renderers show of colors of corners"


@pytest.mark.parametrize(("flat", "corners"), [(True, 3 * 80), (False, 42)])
def test_flat_visuals_show_every_edge_and_others_the_sharp_ones(tmp_path: Path, flat: bool, corners: int) -> None:
    ball = trimesh.creation.icosphere(1, 0.2)  # 42 vertices, 80 faces, no edge sharper than 35 degrees
    link = Link("ball", [Visual(ball, (1.0, 0.0, 0.0, 1.0), flat)], [ball], 1.0, np.zeros(3), np.eye(3))
    write_urdf(RobotModel("r", {"ball": link}), tmp_path)
    lines = (tmp_path / "meshes" / "ball_0.obj").read_text().splitlines()
    assert sum(line.startswith("v ") for line in lines) == corners
    normals = np.array([line.split()[1:] for line in lines if line.startswith("vn ")], dtype=float)
    faces = [[int(corner.split("//")[1]) - 1 for corner in line.split()[1:]] for line in lines if line[0] == "f"]
    assert all(np.allclose(normals[face], normals[face[0]]) for face in faces) == flat


@pytest.mark.parametrize(
    ("geometry", "size"),
    [
        ('<cylinder radius="0.1" length="0.6"/>', (0.2, 0.2, 0.6)),
        ('<capsule radius="0.1" length="0.6"/>', (0.2, 0.2, 0.8)),
        ('<sphere radius="0.1"/>', (0.2, 0.2, 0.2)),
        ('<box size="0.1 0.2 0.3"/>', (0.1, 0.2, 0.3)),
        ('<mesh filename="cube.obj" scale="1 2 3"/>', (1.0, 2.0, 3.0)),
    ],
)
def test_shapes_are_centerd_and_have_their_size(tmp_path: Path, geometry: str, size: tuple[float, ...]) -> None:
    trimesh.creation.box().export(tmp_path / "cube.obj")
    shape = f'<origin xyz="1 0 0"/><geometry>{geometry}</geometry>'
    link = f'<link name="a"><visual>{shape}</visual><collision>{shape}</collision></link>'
    robot = read(tmp_path, f'<robot name="r">{link}</robot>')
    low, high = measure_closed_box(robot)
    assert np.allclose((low + high) / 2, [1, 0, 0], atol=1e-6)
    assert np.allclose(high - low, size, atol=2e-3)
    (piece,) = robot.links["a"].collisions
    assert piece.is_convex and np.allclose(piece.bounds, [low, high])


def test_parts_of_one_colour_and_two_textures_are_each_written_once(tmp_path: Path) -> None:
    solid = trimesh.creation.box((0.1, 0.2, 0.3))
    textures = [None, Texture("oak", b"", (1.0, 1.0)), Texture("ash", b"", (1.0, 1.0))]
    seen = [Visual(solid, (0.5, 0.4, 0.3, 1.0), flat=True, texture=texture) for texture in textures]
    link = Link("a", seen, [solid], 1.0, np.zeros(3), np.eye(3))
    write_urdf(RobotModel("r", {"a": link}), tmp_path / "r")
    assert [path.read_text().count("\nf ") for path in sorted((tmp_path / "r/meshes").glob("a_?.obj"))] == [12] * 3


def test_a_material_file_that_is_missing_is_no_texture(tmp_path: Path) -> None:
    textured_box((1.0, 1.0, 1.0), tmp_path, "box")
    text = (
        '<robot name="r"><link name="a"><visual><geometry><mesh filename="box.obj"/></geometry>'
        '<material name="red"><color rgba="1 0 0 1"/></material></visual></link></robot>'
    )
    (textured,) = read(tmp_path, text).links["a"].visuals
    assert textured.color is None, "the texture wins over the color"
    (tmp_path / "box.mtl").unlink()
    (plain,) = read(tmp_path, text).links["a"].visuals
    assert plain.color == (1.0, 0.0, 0.0, 1.0)


def test_joints_in_any_order(tmp_path: Path) -> None:
    """Parents may stand after their children in the file."""
    write_cabinet(tmp_path)
    lines = CABINET.split("\n")
    knob = next(line for line in lines if 'name="knob"' in line)
    text = "\n".join(line for line in lines if line != knob).replace(
        '  <joint name="hinge"', f'{knob}\n  <joint name="hinge"'
    )
    (tmp_path / "b.urdf").write_text(text)
    assert [joint.name for joint in UrdfTree(tmp_path / "b.urdf").joints] == ["hinge", "slide", "knob"]
    boxes = [measure_closed_box(read(tmp_path, t)) for t in (text, CABINET)]
    assert np.allclose(*boxes)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('type="prismatic"', 'type="continuous"'),
        ('type="prismatic"', 'type="fixed"'),
        ('lower="0" upper="0.2"', 'lower="0" upper="0.00001"'),
        ('<axis xyz="0 -1 0"/>', '<axis xyz="0 -1 0"/><mimic joint="hinge"/>'),
    ],
)
def test_what_turns_without_end_follows_or_hardly_moves_is_fixed(tmp_path: Path, old: str, new: str) -> None:
    robot = assign_part_types(read(tmp_path, CABINET.replace(old, new)))
    assert [(joint.name, joint.type, joint.part_type) for joint in robot.joints] == [
        ("hinge", "revolute", "door"),
        ("knob", "fixed", None),
        ("slide", "fixed", None),
    ]


def test_the_chain_of_an_arm_is_read_from_the_same_tree(tmp_path: Path) -> None:
    from roomkin.stages.simulation.kinematics import read_chain

    def hinge(number: int, origin: str) -> str:
        limit = f'<limit lower="-{number}" upper="2"/>'
        ends = f'<parent link="l{number - 1}"/><child link="l{number}"/>'
        return f'<joint name="j{number}" type="revolute">{ends}{origin}<axis xyz="0 0 1"/>{limit}</joint>'

    links = "".join(f'<link name="l{k}"/>' for k in range(3)) + '<link name="tip"/>'
    bolt = '<joint name="bolt" type="fixed"><parent link="l2"/><child link="tip"/><origin xyz="0 0 0.5"/></joint>'
    joints = bolt + hinge(2, '<origin xyz="1 0 0" rpy="1.5707963267948966 0 0"/>') + hinge(1, "")
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')
    chain = read_chain(tmp_path / "arm.urdf", "tip")
    assert (chain.lower.tolist(), chain.upper.tolist()) == ([-1.0, -2.0], [2.0, 2.0])
    assert np.allclose(chain.pose(np.array([[0.0, 0.0], [np.pi / 2, 0.0]]))[:, :3, 3], [[1, -0.5, 0], [0.5, 1, 0]])
    with pytest.raises(InputError, match="has no hinge that moves a link 'hand'"):
        read_chain(tmp_path / "arm.urdf", "hand")


def test_a_mirrored_mesh_keeps_its_outside_out(tmp_path: Path) -> None:
    trimesh.creation.icosphere(1, 0.5).export(tmp_path / "ball.obj")
    geometry = '<mesh filename="ball.obj" scale="-1 1 2"/>'
    robot = read(
        tmp_path, f'<robot name="r"><link name="a"><visual><geometry>{geometry}</geometry></visual></link></robot>'
    )
    assert robot.links["a"].visuals[0].mesh.volume > 0
    assert stretch_model(robot, (1, 1, 0.5)).links["a"].mass == pytest.approx(robot.mass / 2)


@pytest.mark.parametrize("room", NO_SIMULATOR)
def test_rooms_that_import_no_simulator(room: str) -> None:
    """DESIGN, rule 5: neither these rooms nor anything they import names one, not even inside a function."""
    home = source(room if "." in room else f"roomkin.stages.{room}")
    assert home is not None
    modules = {name for path in home.parent.rglob("*.py") for name in closure(module_name(path, home))}
    assert len(modules) > 3
    for name in sorted(modules):
        path = source(name)
        assert path is not None
        found = imported(path) & SIMULATORS
        assert not found, f"{name} imports {found}"


def module_name(path: Path, home: Path) -> str:
    inside = path.relative_to(home.parents[1]).with_suffix("").parts
    return ".".join(["roomkin", home.parents[1].name, *(part for part in inside if part != "__init__")])


def imported(path: Path) -> set[str]:
    """First words of all modules that a file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


def test_the_walk_over_imports_would_find_a_simulator() -> None:
    found = {
        name
        for module in closure("roomkin.stages.simulation.loading")
        if (path := source(module))
        for name in imported(path)
    }
    assert "sapien" in found
    assert read_model.__module__ in closure("roomkin.stages.generation.placed")


@pytest.mark.parametrize("kind", ["bar", "arch", "knob", "edge"])
def test_extents_of_a_handle_are_those_that_rays_find(tmp_path: Path, kind: str) -> None:
    asset = cabinet(tmp_path / "cab", handle=kind, panel="raised")
    robot, joint = read_model(tmp_path / "cab"), asset.joints[0]
    mesh = merge_visuals(robot, [joint.link], link_frames(robot))
    assert mesh is not None
    found, (low, high) = find_handle(mesh), handle_extents(tmp_path / "cab", asset, joint.name)
    assert found is not None and (low + high)[1:] / 2 == pytest.approx(found.position[1:], abs=0.005)
    along = max((high - low)[1:])
    assert found.length - 0.004 <= along <= found.length * 1.2 and high[0] == pytest.approx(found.position[0], abs=1e-3)
