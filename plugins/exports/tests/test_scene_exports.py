"""A generated scene as GLB, URDF, MJCF and USD, each read again by somebody else's reader, and simulated."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh import Trimesh

from roomkin.plugins.exports import scenes
from roomkin.plugins.exports.scene_formats import mjcf, urdf
from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import build
from roomkin.plugins.pictures import glb
from roomkin.stages.articulated.asset_folder import Description, read_asset, write_asset
from roomkin.stages.articulated.model import Link, RobotModel, Visual
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.contracts import GeneratedScene, LibraryPart, write_json
from roomkin.stages.contracts.generated import ROOM_LIGHT, Look, Surface
from roomkin.stages.contracts.objects import Mounting, Wall
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.scene_file import ExportedScene, room_of
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import look_at

FOCAL, MIDDLE = 150.0, (90.0, 80.0)  # pixels; not the middle of the picture
WIDTH, HEIGHT = 200, 150


def _painting(folder: Path) -> None:
    """A board with a texture."""
    board = trimesh.creation.box((0.04, 0.5, 0.4))
    uv = board.vertices[:, 1:] / (0.5, 0.4) + 0.5
    image = Image.fromarray(np.random.default_rng(0).integers(0, 255, (16, 16, 3)).astype(np.uint8))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image, metallicFactor=0.0)
    board.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    hull = Trimesh(board.vertices, board.faces)
    link = Link("base", [Visual(board)], [hull], 0.8, np.zeros(3), np.eye(3) * 0.02)
    write_asset(RobotModel("painting", {"base": link}), folder, Description("painting", "picture", "CC0-1.0", "test"))


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> ExportedScene:
    """A cabinet that is held by the wall x = 3.3, a mug on it that is free, a painting above."""
    folder = tmp_path_factory.mktemp("models")
    for name in ("bottom_cabinet", "mug"):
        build(sample(name, 0, 0), None, folder / name, name, name)
    _painting(folder / "painting")
    cabinet, mug, painting = (read_asset(folder / name) for name in ("bottom_cabinet", "mug", "painting"))
    top, depth = cabinet.size[2], cabinet.size[0]
    hung, loose = Mounting(type=1, walls=["wall_1"]), Mounting(type=2)
    boxes = (
        UprightBox((3.3 - depth / 2, 0.2, top / 2), cabinet.size, np.pi),
        UprightBox((3.0, 0.3, top + mug.size[2] / 2), mug.size, 0.4),
        UprightBox((3.28, 0.2, 1.8), painting.size, np.pi),
    )
    items = [
        Placed("cabinet_1", "cabinet", cabinet, folder / "bottom_cabinet", boxes[0], hung),
        Placed("mug_1", "mug", mug, folder / "mug", boxes[1], loose, "cabinet_1"),
        Placed("picture_1", "picture", painting, folder / "painting", boxes[2], hung, "wall"),
    ]
    made = GeneratedScene(
        scene="room_t",
        variant="default",
        rank=1,
        width=WIDTH,
        height=HEIGHT,
        intrinsics=[[FOCAL, 0, MIDDLE[0]], [0, FOCAL, MIDDLE[1]], [0, 0, 1]],
        floor_from_camera=look_at([0, 0, 1.5], [3, 0, 0.5]).tolist(),
        walls=[Wall(id="wall_1", normal=(-1, 0, 0), offset=-3.3, points=99)],
        objects=[],
    )
    surfaces = [Surface(id="floor", colour=(0.5, 0.3, 0.1), low=(0, -2), high=(3.3, 2))]
    look = Look(light=(0.6, 0, -0.8), light_from="shadows", shadow_correlation=0.9, surfaces=surfaces)
    return room_of(made, items, look)


def body(room: ExportedScene, name: str) -> Any:
    return next(each for each in room.bodies if each.id == name)


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def loosened(room: ExportedScene) -> ExportedScene:
    """The same with a cabinet that stands by itself."""
    return replace(room, bodies=[replace(each, fixed=each.id == "picture_1") for each in room.bodies])


def test_trimesh_reads_the_glb(room: ExportedScene, tmp_path: Path) -> None:
    for name in ("a", "b"):
        glb.write(room, tmp_path / f"{name}.glb")
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()
    scene = trimesh.load_scene(tmp_path / "a.glb")
    cabinet = body(room, "cabinet_1")
    names = [name for name in scene.graph.nodes_geometry if name.startswith("cabinet_1/")]
    corners = [trimesh.transform_points(scene.geometry[g].bounds, pose) for n in names for pose, g in [scene.graph[n]]]
    low, high = np.min(np.concatenate(corners), axis=0), np.max(np.concatenate(corners), axis=0)
    assert high[0] == pytest.approx(3.3, abs=1e-4) and low[1] == pytest.approx(0, abs=1e-4)  # y is up
    assert high - low == pytest.approx(np.array(cabinet.asset.size)[[0, 2, 1]], abs=1e-3)
    nodes = scene.graph.transforms.node_data
    assert {"floor", "wall_1", "mug_1", "picture_1"} <= set(nodes)
    joint = cabinet.moving[0]
    edge = scene.graph.transforms.edge_data[("cabinet_1", f"cabinet_1/{joint.child}")]["metadata"]
    assert edge["joint"] == joint.type and edge["upper"] == pytest.approx(joint.upper, abs=1e-4)
    assert edge["mass"] == pytest.approx(cabinet.model.links[joint.child].mass, abs=1e-3)
    written = (tmp_path / "a.glb").read_bytes()
    header = json.loads(written[20 : 20 + int.from_bytes(written[12:16], "little")])
    assert header["cameras"][0]["perspective"]["aspectRatio"] == pytest.approx(WIDTH / HEIGHT)
    textured = scene.geometry["picture_1/base/0"].visual.material.baseColorTexture
    assert textured is not None and textured.size == (16, 16)
    floor = scene.geometry["floor"].visual.material.baseColorFactor
    assert np.array(floor[:3]) / 255 == pytest.approx((0.5, 0.3, 0.1), abs=0.01)
    assert scene.camera.fov[1] == pytest.approx(np.degrees(2 * np.arctan(HEIGHT / 2 / FOCAL)), abs=1e-3)


def test_the_look_of_the_picture_is_exported_where_it_is_given(
    room: ExportedScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[ExportedScene] = []
    monkeypatch.setattr(scenes.glb, "write", lambda made, out: written.append(made))
    look = Look(light=(0.6, 0, -0.8), light_from="shadows", shadow_correlation=0.9, surfaces=[])
    for name, value in {"scene": room.scene, "library": LibraryPart(assets=[]), "look": look}.items():
        write_json(tmp_path / f"{name}.json", value)
    monkeypatch.setattr(scenes, "read_items", lambda *given: [])
    files: dict[str, Any] = {"scenes": (tmp_path / "scene.json",), "library": tmp_path / "library.json"}
    for given in (None, tmp_path / "look.json"):
        scenes.run(**files, format="glb", out=tmp_path, look=given)
    assert [made.light.tolist() for made in written] == [list(ROOM_LIGHT), [0.6, 0.0, -0.8]]


def test_every_urdf_is_read_by_our_own_reader(room: ExportedScene, tmp_path: Path) -> None:
    urdf.write(room, tmp_path / "out")
    urdf.write(room, tmp_path / "again")
    assert files(tmp_path / "out") == files(tmp_path / "again")
    placed = json.loads((tmp_path / "out/scene.json").read_text())["objects"]
    assert [each["id"] for each in placed] == ["cabinet_1", "mug_1", "picture_1"]
    for told in placed:
        model = read_urdf(tmp_path / "out" / told["urdf"], tmp_path / "out" / "models" / told["id"])
        there = body(room, told["id"])
        assert model.mass == pytest.approx(there.model.mass, rel=1e-3)
        assert told["position"] == pytest.approx(there.pose[:3, 3].tolist(), abs=1e-5)
        assert told["fixed"] == there.fixed


def test_yourdfpy_reads_the_urdf(room: ExportedScene, tmp_path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy", reason="yourdfpy is missing: make setup")
    urdf.write(room, tmp_path)
    whole = yourdfpy.URDF.load(
        str(tmp_path / "scene.urdf"), build_collision_scene_graph=True, load_collision_meshes=True
    )
    assert whole.base_link == "world" and whole.joint_map["mug_1__place"].type == "floating"
    assert whole.joint_map["cabinet_1__place"].type == "fixed"
    joint = body(room, "cabinet_1").moving[0]
    there = whole.joint_map[f"cabinet_1__{joint.name}"]
    assert (there.type, there.limit.upper) == (joint.type, pytest.approx(joint.upper, abs=1e-4))
    alone = yourdfpy.URDF.load(str(tmp_path / "models/cabinet_1/model.urdf"))
    assert alone.scene.extents == pytest.approx(body(room, "cabinet_1").asset.size, abs=1e-3)
    assert (whole.scene.geometry.keys() & alone.scene.geometry.keys()) and not list(tmp_path.glob("meshes"))  # shared
    before = alone.get_transform(joint.child)
    alone.update_cfg({joint.name: joint.upper})
    assert np.abs(alone.get_transform(joint.child) - before).max() > 0.1


@pytest.fixture(scope="module")
def model(room: ExportedScene, tmp_path_factory: pytest.TempPathFactory) -> mujoco.MjModel:
    """The scene as MuJoCo compiles it."""
    out = tmp_path_factory.mktemp("mjcf") / "out"
    mjcf.write(room, out)
    return mujoco.MjModel.from_xml_path(str(out / "scene.xml"))


def test_mujoco_compiles_the_mjcf(room: ExportedScene, model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for each in room.bodies:
        for name, link in each.model.links.items():
            there = model.body(f"{each.id}/{name}")
            assert there.mass[0] == pytest.approx(link.mass, rel=1e-4)
            pose = each.pose @ each.frames[name]
            assert data.xpos[there.id] == pytest.approx(pose[:3, 3], abs=1e-5)
    kinds = {model.joint(index).name: model.jnt_type[index] for index in range(model.njnt)}
    assert kinds["mug_1"] == mujoco.mjtJoint.mjJNT_FREE and "cabinet_1" not in kinds and "picture_1" not in kinds
    joint = body(room, "cabinet_1").moving[0]
    assert model.joint(f"cabinet_1/{joint.name}").range == pytest.approx([joint.lower, joint.upper], abs=1e-5)
    assert 16 in model.tex_width[: model.ntex]


def test_mujoco_sees_through_the_input_camera(room: ExportedScene, model: mujoco.MjModel) -> None:
    data, scene = mujoco.MjData(model), mujoco.MjvScene(model, 1000)
    mujoco.mj_forward(model, data)
    view = mujoco.MjvCamera()
    view.type, view.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, model.camera("input_camera").id
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, view, mujoco.mjtCatBit.mjCAT_ALL, scene)
    camera = scene.camera[0]
    assert np.array(camera.forward) == pytest.approx(room.world_from_camera[:3, 2], abs=1e-5)
    assert np.array(camera.up) == pytest.approx(-room.world_from_camera[:3, 1], abs=1e-5)
    top, bottom = camera.frustum_top / camera.frustum_near, camera.frustum_bottom / camera.frustum_near
    assert top == pytest.approx((MIDDLE[1] + 0.5) / FOCAL, abs=1e-3)
    right = (camera.frustum_center + camera.frustum_width) / camera.frustum_near
    assert right == pytest.approx((WIDTH - MIDDLE[0] - 0.5) / FOCAL, abs=1e-3)
    assert bottom == pytest.approx(-(HEIGHT - MIDDLE[1] - 0.5) / FOCAL, abs=1e-3)


def test_nothing_flies_away_in_mujoco_and_doors_open(room: ExportedScene, model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = data.xpos.copy()
    for _ in range(round(1 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.xpos - start, axis=1).max() < 0.01
    for joint in body(room, "cabinet_1").moving:
        mujoco.mj_resetData(model, data)
        there = model.joint(f"cabinet_1/{joint.name}")
        for _ in range(round(1.5 / model.opt.timestep)):
            data.qfrc_applied[there.dofadr[0]] = 8.0  # N m, or N
            mujoco.mj_step(model, data)
        assert data.qpos[there.qposadr[0]] - joint.lower > 0.5 * (joint.upper - joint.lower), joint.name


def test_a_cabinet_that_stands_by_itself_stays_where_it_is(room: ExportedScene, tmp_path: Path) -> None:
    mjcf.write(loosened(room), tmp_path)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.joint("cabinet_1").type[0] == mujoco.mjtJoint.mjJNT_FREE
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = data.xpos.copy()
    for _ in range(round(1 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.xpos - start, axis=1).max() < 0.01


def test_pxr_reads_the_usd(room: ExportedScene, tmp_path: Path) -> None:
    pxr = pytest.importorskip("pxr.Usd", reason="usd-core is missing: make setup")
    from pxr import UsdGeom, UsdPhysics

    from roomkin.plugins.exports.scene_formats import usd

    for name in ("a", "b"):
        usd.write(room, tmp_path / name)
    assert files(tmp_path / "a") == files(tmp_path / "b")
    stage = pxr.Stage.Open(str(tmp_path / "a/scene.usdc"))
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    seen = UsdGeom.BBoxCache(pxr.TimeCode.Default(), [UsdGeom.Tokens.default_])
    cabinet, mug = (stage.GetPrimAtPath(f"/World/{name}") for name in ("cabinet_1", "mug_1"))
    box = seen.ComputeWorldBound(cabinet).ComputeAlignedRange()
    assert box.GetMax()[0] == pytest.approx(3.3, abs=1e-4) and box.GetMin()[2] == pytest.approx(0, abs=1e-4)
    assert np.array(box.GetSize()) == pytest.approx(body(room, "cabinet_1").asset.size, abs=1e-3)
    assert cabinet.HasAPI(UsdPhysics.ArticulationRootAPI) and stage.GetPrimAtPath("/World/cabinet_1/held")
    assert mug.GetChild("base").HasAPI(UsdPhysics.RigidBodyAPI)
    picture = stage.GetPrimAtPath("/World/picture_1/base")
    assert not picture.HasAPI(UsdPhysics.RigidBodyAPI)  # it hangs
    for name, link in body(room, "cabinet_1").model.links.items():
        mass = UsdPhysics.MassAPI(cabinet.GetChild(name)).GetMassAttr().Get()
        assert mass == pytest.approx(link.mass, rel=1e-5)
    joint = body(room, "cabinet_1").moving[0]
    kind, unit = (UsdPhysics.RevoluteJoint, 180 / np.pi) if joint.type == "revolute" else (UsdPhysics.PrismaticJoint, 1)
    there = kind(stage.GetPrimAtPath(f"/World/cabinet_1/{joint.name}_joint"))
    assert there.GetUpperLimitAttr().Get() == pytest.approx(joint.upper * unit, rel=1e-4)
    cache = UsdGeom.XformCache()
    ends = []
    for side, link in ((0, joint.parent), (1, joint.child)):
        prim = stage.GetPrimAtPath(f"/World/cabinet_1/{link}")
        ends.append(cache.GetLocalToWorldTransform(prim).Transform(getattr(there, f"GetLocalPos{side}Attr")().Get()))
    assert np.array(ends[0]) == pytest.approx(np.array(ends[1]), abs=1e-5)  # closed: the frames meet
    usd.write(loosened(room), tmp_path / "loose")
    loose = pxr.Stage.Open(str(tmp_path / "loose/scene.usdc"))
    assert not loose.GetPrimAtPath("/World/cabinet_1/held") and loose.GetPrimAtPath("/World/cabinet_1/base")
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/input_camera")).GetCamera().frustum
    window = camera.window
    assert window.GetMax()[0] == pytest.approx((WIDTH - MIDDLE[0] - 0.5) / FOCAL, abs=1e-3)
    assert window.GetMax()[1] == pytest.approx((MIDDLE[1] + 0.5) / FOCAL, abs=1e-3)
    sizes = [Image.open(path).size for path in sorted((tmp_path / "a/textures").iterdir())]
    assert sizes.count((16, 16)) == 1
