"""Exports of what is tilted: camera, bodies and joint origins that roll and pitch, lower limits that are not 0."""

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from trimesh import Trimesh

from roomkin.plugins.exports.scene_formats import mjcf, urdf
from roomkin.plugins.pictures import glb
from roomkin.stages.articulated.asset_folder import Description, read_asset, read_model, write_asset
from roomkin.stages.articulated.model import JointModel, Link, RobotModel, Visual, link_frames
from roomkin.stages.contracts import GeneratedScene
from roomkin.stages.generation.scene_file import Body, ExportedScene
from roomkin.stages.geometry.frames import invert_transform, make_transform

LOWER, UPPER = 0.35, 1.2
POSE = make_transform(Rotation.from_euler("xyz", [0.3, -0.5, 0.9]).as_matrix(), [2.0, 0.3, 0.8])
CAMERA = make_transform(Rotation.from_euler("xyz", [-1.9, 0.25, -1.2]).as_matrix(), [0.0, 0.1, 1.5])
ORIGIN = make_transform(Rotation.from_euler("xyz", [0.4, 0.7, -0.6]).as_matrix(), [0.1, 0.2, 0.3])
SLIDE = make_transform(Rotation.from_euler("xyz", [-0.8, 0.2, 0.5]).as_matrix(), [-0.1, 0.1, 0.2])


def link(name: str, size: tuple[float, float, float], turn: float) -> Link:
    """A board with a box of inertia that is turned."""
    board = trimesh.creation.box(size)
    axes = Rotation.from_euler("xyz", [turn, -turn, 2 * turn]).as_matrix()
    visual = Visual(board, (0.5, 0.3, 0.2, 1.0))
    hull = Trimesh(board.vertices, board.faces)
    return Link(name, [visual], [hull], 2.0, np.array([0.01, 0.02, 0.03]), axes @ np.diag([0.03, 0.02, 0.04]) @ axes.T)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> ExportedScene:
    """A body with a door and a drawer, tilted in every way."""
    folder = tmp_path_factory.mktemp("model") / "tilted"
    links = [
        link("base", (0.4, 0.5, 0.6), 0.2),
        link("door", (0.02, 0.3, 0.4), 0.5),
        link("drawer", (0.3, 0.2, 0.1), 0.9),
    ]
    axis = np.array([0.6, 0.0, 0.8])
    joints = [
        JointModel("hinge", "revolute", "base", "door", ORIGIN, axis, LOWER, UPPER, part_type="door"),
        JointModel("runner", "prismatic", "base", "drawer", SLIDE, axis, 0.05, 0.3, part_type="drawer"),
    ]
    model = RobotModel("tilted", {each.name: each for each in links}, joints)
    write_asset(model, folder, Description("tilted", "cabinet", "CC0-1.0", "test"))
    body = Body("tilted_1", "cabinet", read_asset(folder), folder, read_model(folder), POSE, fixed=True)
    made = GeneratedScene(
        scene="room_t", variant="default", rank=1, width=200, height=150,
        intrinsics=[[150.0, 0, 99.5], [0, 150.0, 74.5], [0, 0, 1]], floor_from_camera=CAMERA.tolist(),
        walls=[], objects=[],
    )  # fmt: skip
    return ExportedScene(made, [body], [], np.array([0.0, 0.6, -0.8]))


def frames(room: ExportedScene, opened: float = 0.0) -> dict[str, np.ndarray]:
    """world_from_link (4, 4) of every link."""
    return {name: POSE @ frame for name, frame in link_frames(room.bodies[0].model, opened).items()}


def test_the_reader_finds_what_was_written(room: ExportedScene) -> None:
    hinge, runner = room.bodies[0].model.joints
    assert (hinge.lower, hinge.upper, runner.lower) == pytest.approx((LOWER, UPPER, 0.05), abs=1e-5)
    assert hinge.origin == pytest.approx(ORIGIN, abs=1e-6) and runner.origin == pytest.approx(SLIDE, abs=1e-6)
    assert hinge.motion(hinge.lower)[:3, :3] == pytest.approx(
        Rotation.from_rotvec(LOWER * np.array([0.6, 0.0, 0.8])).as_matrix(), abs=1e-6
    )
    by_hand = ORIGIN @ make_transform(Rotation.from_rotvec(UPPER * np.array([0.6, 0.0, 0.8])).as_matrix(), np.zeros(3))
    assert link_frames(room.bodies[0].model, 1.0)["door"] == pytest.approx(by_hand, abs=1e-6)


def test_urdf(room: ExportedScene, tmp_path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy", reason="yourdfpy is missing: make setup")
    urdf.write(room, tmp_path)
    whole = yourdfpy.URDF.load(str(tmp_path / "scene.urdf"))
    assert whole.get_transform("input_camera") == pytest.approx(CAMERA, abs=1e-5)
    for opened in (0.0, 1.0):
        values = {"tilted_1__hinge": (LOWER, UPPER), "tilted_1__runner": (0.05, 0.3)}
        whole.update_cfg({name: ends[int(opened)] for name, ends in values.items()})
        for name, pose in frames(room, opened).items():
            assert whole.get_transform(f"tilted_1__{name}") == pytest.approx(pose, abs=1e-5)
    assert whole.joint_map["tilted_1__hinge"].limit.lower == pytest.approx(LOWER, abs=1e-5)
    told = json.loads((tmp_path / "scene.json").read_text())
    turn = Rotation.from_quat(told["objects"][0]["quaternion_wxyz"], scalar_first=True).as_matrix()
    assert turn == pytest.approx(POSE[:3, :3], abs=1e-5)
    assert np.array(told["camera"]["world_from_camera"]) == pytest.approx(CAMERA)


def test_mjcf(room: ExportedScene, tmp_path: Path) -> None:
    mjcf.write(room, tmp_path / "out")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out/scene.xml"))
    data = mujoco.MjData(model)
    for opened in (0.0, 1.0):
        for name, ends in (("hinge", (LOWER, UPPER)), ("runner", (0.05, 0.3))):
            joint = model.joint(f"tilted_1/{name}")
            assert joint.range == pytest.approx(ends, abs=1e-5)
            assert data.qpos[joint.qposadr[0]] == pytest.approx(ends[0], abs=1e-5) or opened
            data.qpos[joint.qposadr[0]] = ends[int(opened)]
        mujoco.mj_forward(model, data)
        for name, pose in frames(room, opened).items():
            there = model.body(f"tilted_1/{name}").id
            assert data.xpos[there] == pytest.approx(pose[:3, 3], abs=1e-5)
            assert data.xmat[there].reshape(3, 3) == pytest.approx(pose[:3, :3], abs=1e-5)
    eye = model.camera("input_camera").id
    assert data.cam_xmat[eye].reshape(3, 3) == pytest.approx(CAMERA[:3, :3] @ np.diag([1, -1, -1]), abs=1e-5)


def test_usd(room: ExportedScene, tmp_path: Path) -> None:
    pxr = pytest.importorskip("pxr.Usd", reason="usd-core is missing: make setup")
    from pxr import UsdGeom, UsdPhysics

    from roomkin.plugins.exports.scene_formats import usd

    usd.write(room, tmp_path / "out")
    stage = pxr.Stage.Open(str(tmp_path / "out/scene.usdc"))
    cache = UsdGeom.XformCache()

    def world(path: str) -> np.ndarray:
        return np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path))).T

    for name, pose in frames(room).items():
        assert world(f"/World/tilted_1/{name}") == pytest.approx(pose, abs=1e-5)
        mass = UsdPhysics.MassAPI(stage.GetPrimAtPath(f"/World/tilted_1/{name}"))
        turn = rotation(mass.GetPrincipalAxesAttr().Get())
        inertia = turn @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ turn.T
        assert inertia == pytest.approx(room.bodies[0].model.links[name].inertia, abs=1e-5)
    assert world("/World/input_camera")[:3, :3] == pytest.approx(CAMERA[:3, :3] @ np.diag([1, -1, -1]), abs=1e-5)
    for joint, kind, unit in (
        ("hinge", UsdPhysics.RevoluteJoint, 180 / np.pi),
        ("runner", UsdPhysics.PrismaticJoint, 1),
    ):
        made, ours = kind(stage.GetPrimAtPath(f"/World/tilted_1/{joint}_joint")), by_name(room, joint)
        ends = made.GetLowerLimitAttr().Get(), made.GetUpperLimitAttr().Get()
        assert ends == pytest.approx((ours.lower * unit, ours.upper * unit), rel=1e-4)
        sides = []
        for side, path in enumerate((ours.parent, ours.child)):
            place = getattr(made, f"GetLocalPos{side}Attr")().Get()
            turn = rotation(getattr(made, f"GetLocalRot{side}Attr")().Get())
            sides.append(world(f"/World/tilted_1/{path}") @ make_transform(turn, place))
        moved = (
            invert_transform(sides[0]) @ sides[1]
        )  # the frames differ by the motion to the lower limit, about or along x
        x = np.array([1.0, 0.0, 0.0])
        closed = (
            make_transform(Rotation.from_rotvec(ours.lower * x).as_matrix(), np.zeros(3))
            if joint == "hinge"
            else make_transform(np.eye(3), ours.lower * x)
        )
        assert moved == pytest.approx(closed, abs=1e-5)


def test_glb(room: ExportedScene, tmp_path: Path) -> None:
    glb.write(room, tmp_path / "a.glb")
    scene = trimesh.load_scene(tmp_path / "a.glb")
    up = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])  # y is up
    for name, pose in frames(room).items():
        assert scene.graph[f"tilted_1/{name}"][0] == pytest.approx(up @ pose, abs=1e-5)
    eye = up @ CAMERA @ np.diag([1, -1, -1, 1])
    assert scene.graph["input_camera"][0] == pytest.approx(eye, abs=1e-5)


def by_name(room: ExportedScene, name: str) -> JointModel:
    return next(joint for joint in room.bodies[0].model.joints if joint.name == name)


def rotation(quaternion: Any) -> np.ndarray:
    return Rotation.from_quat([*quaternion.GetImaginary(), quaternion.GetReal()]).as_matrix()


def test_a_body_stretched_along_an_axis_keeps_its_closed_places(room: ExportedScene) -> None:
    from roomkin.stages.articulated.resizing import stretch_model

    model, scale = room.bodies[0].model, (1.5, 0.8, 1.2)
    made = stretch_model(model, scale)
    for name, frame in link_frames(model).items():
        assert link_frames(made)[name][:3, 3] == pytest.approx(np.array(scale) * frame[:3, 3], abs=1e-6)
    runner, longer = by_name(room, "runner"), next(joint for joint in made.joints if joint.name == "runner")
    travel = link_frames(model, 1.0)["drawer"][:3, 3] - link_frames(model)["drawer"][:3, 3]
    stretch = link_frames(made, 1.0)["drawer"][:3, 3] - link_frames(made)["drawer"][:3, 3]
    assert stretch == pytest.approx(np.array(scale) * travel, abs=1e-6)
    assert longer.lower / runner.lower == pytest.approx(longer.upper / runner.upper)
