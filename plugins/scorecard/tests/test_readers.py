"""Scenes of other formats: boxes of a size, at a place and a turn that are known."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from roomkin.plugins.scorecard import placing, reading, scoring, standing
from roomkin.plugins.scorecard.readers import mjcf, plain, solid
from roomkin.plugins.scorecard.tests.rooms import CABINET, HEAD, MUG, POSE, TABLE, TRUTH
from roomkin.plugins.scorecard.truth import Submission, TrueThing
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import OPENGL, Y_UP, invert_transform, make_transform, yaw_matrix
from tests.refusals import refused

NAMES = {"dining table": "table", "cup": "mug", "cupboard": "cupboard"}


def read(folder: Path) -> Submission:
    """The submission of a folder."""
    (folder / "method.json").write_text(json.dumps(HEAD))
    return reading.read_submission(folder, ["toy_room_1"])


def check(submission: Submission) -> None:
    """Every thing is right."""
    assert submission.unread == {}
    scene, asked = submission.rooms["toy_room_1"], TRUTH.list_asked(drawn=False)
    placed = placing.place_room(scene.room, TRUTH, asked)
    for row in scoring.score_room(TRUTH, asked, scene, placed, {}):
        assert row.sensible and row.size and row.carrier and (row.off_place_cm or 0) < 0.1, row
        assert row.yaw_degrees is None or row.yaw_degrees < 0.1


def pose_of(thing: TrueThing) -> Any:
    """World from a thing."""
    return make_transform(yaw_matrix(thing.yaw), thing.position)


@pytest.mark.parametrize("upright", ["z", "y"])
@pytest.mark.parametrize("camera", [True, False])
def test_a_glb_of_nodes(tmp_path: Path, upright: str, camera: bool) -> None:
    """Own axes of nodes as in URDF (z up, front x) or as in glTF (y up, front z); with a camera, or in its frame."""
    own = (
        np.eye(4)
        if upright == "z"
        else invert_transform(Y_UP) @ make_transform([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], np.zeros(3))
    )
    base = Y_UP if camera else invert_transform(POSE @ OPENGL)
    scene = trimesh.Scene()
    for thing in (TABLE, MUG, CABINET):
        mesh = trimesh.creation.box(thing.size).apply_transform(invert_transform(own))
        scene.add_geometry(
            mesh, node_name=NAMES[thing.label], geom_name=thing.name, transform=base @ pose_of(thing) @ own
        )
    scene.add_geometry(trimesh.creation.box((9, 9, 0.1)), node_name="floor", geom_name="floor", transform=base)
    if camera:
        scene.graph.update(frame_to="camera", frame_from="world", matrix=Y_UP @ POSE @ OPENGL)
    (tmp_path / "toy_room_1.glb").write_bytes(scene.export(file_type="glb"))
    submission = read(tmp_path)
    assert len(submission.rooms["toy_room_1"].room.things) == 3, "the floor is none"
    if camera:
        check(submission)
        assert standing.fill_solid(submission.rooms["toy_room_1"].solids[0]).all()  # a box is filled
    else:
        placed = placing.place_room(submission.rooms["toy_room_1"].room, TRUTH, TRUTH.list_asked(drawn=False))
        assert {number: round(float(np.linalg.norm(placed.boxes[place].center - thing.position)), 3)
                for thing in (TABLE, MUG, CABINET) for number, place in [(thing.number, placed.pairs[thing.number])]
                } == {1: 0, 2: 0, 3: 0}  # fmt: skip


def test_extras_of_a_node_name_it_before_its_id(tmp_path: Path) -> None:
    """As our own GLBs have them; walls are told by theirs, whatever they are called."""
    scene = trimesh.Scene()
    for name, extras in (("object_7", {"category": "mug"}), ("north", {"surface": "wall"})):
        scene.graph.update(frame_to=name, frame_from="world", matrix=np.eye(4), metadata=extras)
        scene.add_geometry(trimesh.creation.box(), node_name=f"{name}/0", geom_name=name, parent_node_name=name)
    (tmp_path / "toy_room_1.glb").write_bytes(scene.export(file_type="glb"))
    assert [thing.name for thing in read(tmp_path).rooms["toy_room_1"].room.things] == ["mug"]


def join(values: Any) -> str:
    """Numbers as MJCF has them."""
    return " ".join(f"{value:.9g}" for value in values)


def write_mjcf(folder: Path, extra: str = "") -> Path:
    """The room for MuJoCo."""
    bodies = ""
    for thing in (TABLE, MUG, CABINET):
        pose = f'pos="{join(thing.position)}" euler="0 0 {np.rad2deg(thing.yaw)}"'
        geom = f'<geom type="box" size="{join(np.array(thing.size) / 2)}"/>'
        bodies += f'<body name="{NAMES[thing.label]}" {pose}>{geom}</body>'
    axes = join((POSE @ OPENGL)[:3, :2].T.ravel())
    camera = f'<camera name="camera" pos="{join(POSE[:3, 3])}" xyaxes="{axes}"/>'
    floor = '<geom type="plane" size="9 9 1"/>'
    path = folder / "toy_room_1.xml"
    path.write_text(f"<mujoco>{extra}<worldbody>{floor}{camera}{bodies}</worldbody></mujoco>")
    return path


def test_a_mujoco_scene(tmp_path: Path) -> None:
    write_mjcf(tmp_path)
    check(read(tmp_path))


@pytest.mark.parametrize(
    ("extra", "code"),
    [
        ('<asset><mesh name="a" file="../secret.stl"/></asset>', "E-FILE-OUTSIDE"),
        ('<compiler meshdir="/etc"/><asset><mesh name="a" file="passwd"/></asset>', "E-FILE-OUTSIDE"),
        ('<asset><mesh name="a" file="link/passwd"/></asset>', "E-FILE-OUTSIDE"),
        (r'<asset><mesh name="a" file="..\secret.stl"/></asset>', "E-FILE-OUTSIDE"),
        ('<include file="other.xml"/>', "E-FORMAT"),
        ('<extension><plugin plugin="a"/></extension>', "E-FORMAT"),
        ("<!DOCTYPE a>", "E-XML-DOCTYPE"),
        ("<asset>", "E-XML-BROKEN"),
    ],
)
def test_a_mujoco_scene_cannot_leave_its_folder(tmp_path: Path, extra: str, code: str) -> None:
    (tmp_path / "link").symlink_to("/etc")
    with refused(code):
        mjcf.check_confined(write_mjcf(tmp_path, extra))
    assert "toy_room_1" in read(tmp_path).unread


def test_what_the_paper_s_authors_code_writes(tmp_path: Path) -> None:
    """A scene as generation.py of their repository builds it: cam_pose and tf_from_cam of an OpenGL camera."""
    from scipy.spatial.transform import Rotation

    view = POSE @ OPENGL
    objects = {
        f"{thing.name}_0": {
            "category": NAMES[thing.label], "model": "abcdef", "scale": [1, 1, 1], "bbox_extent": list(thing.size),
            "tf_from_cam": (invert_transform(view) @ pose_of(thing)).tolist(), "mount": {"floor": True, "wall": None},
        }
        for thing in (TABLE, MUG, CABINET)
    }  # fmt: skip
    camera = [view[:3, 3].tolist(), Rotation.from_matrix(view[:3, :3]).as_quat().tolist()]
    path = tmp_path / "toy_room_1/step_3_output/scene_0/scene_0_info.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"resolution": [480, 640], "scene_graph": "x", "cam_pose": camera, "objects": objects}))
    check(read(tmp_path))


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("toy_room_1.json", b"{", "is no JSON"),
        ("toy_room_1.json", b'{"cam_pose": 3, "objects": {}}', "another form"),
        ("toy_room_1.glb", b"glTF", ""),
        ("toy_room_1.xml", b"<mujoco/>", "no camera called 'camera'"),
        ("toy_room_1.usd", b"PXR", ""),
        ("toy_room_1.blend", b"PXR", "has a format that is not read. Fix: one of JSON, GLB, XML, USD"),
    ],
)
def test_what_cannot_be_read_is_told_by_room(tmp_path: Path, name: str, content: bytes, told: str) -> None:
    (tmp_path / name).write_bytes(content)
    assert told in read(tmp_path).unread["toy_room_1"]


def test_a_folder_must_say_what_method_it_is_of(tmp_path: Path) -> None:
    with refused("E-FILE-MISSING", "method.json"):
        reading.read_submission(tmp_path, ["toy_room_1"])


def test_the_front_of_a_thing_is_found_by_its_upright_axis() -> None:
    assert solid.find_yaw(yaw_matrix(0.7)) == pytest.approx(0.7)
    gltf = invert_transform(Y_UP)[:3, :3]
    assert solid.find_yaw(gltf) == pytest.approx(-np.pi / 2)  # glTF's z is our -y


CHAIR = trimesh.util.concatenate([
    trimesh.creation.box((0.4, 0.4, 0.04)).apply_translation((0, 0, 0.02)),
    trimesh.creation.box((0.04, 0.4, 0.4)).apply_translation((-0.18, 0, 0.2)),
])  # fmt: skip
GLTF = Y_UP @ make_transform(yaw_matrix(-np.pi / 2), np.zeros(3))  # y up, front +z


def write_thing(folder: Path, mesh: str) -> Submission:
    """A room of a chair with a mesh, in one file."""
    thing = {"name": "chair", "center": [1, 1, 1], "size": [0.8, 0.4, 0.4], "mesh": mesh}
    room = {"frame": "camera", "things": [thing]}
    (folder / "mine.json").write_text(json.dumps(HEAD | {"rooms": {"toy_room_1": room}}))
    return reading.read_submission(folder / "mine.json", ["toy_room_1"])


@pytest.mark.parametrize("kind", ["glb", "obj"])
def test_a_thing_may_name_its_mesh(tmp_path: Path, kind: str) -> None:
    own = CHAIR.copy().apply_transform(GLTF) if kind == "glb" else CHAIR.copy()
    text = own.export(file_type=kind)
    data = text if isinstance(text, bytes) else f"mtllib /etc/passwd\n{text}".encode()
    (tmp_path / "meshes").mkdir()
    (tmp_path / f"meshes/chair.{kind}").write_bytes(data)
    read = write_thing(tmp_path, f"meshes/chair.{kind}")
    assert read.unread == {}
    solid = read.rooms["toy_room_1"].solids[0]
    assert solid.extents == pytest.approx([0.4, 0.4, 0.4]) and solid.bounds.sum() == pytest.approx(0)
    filled = standing.fill_solid(solid)
    assert filled[0, 12, 20] and not filled[20, 12, 20] and filled[20, 12, 0]  # its back is behind, its seat below
    hulls = np.concatenate(standing.cut_solid(solid, UprightBox((1, 1, 1), (0.8, 0.4, 0.4), 0.3)))
    assert np.ptp(hulls, axis=0) == pytest.approx([0.8, 0.4, 0.4], abs=0.01)  # stretched into the box


@pytest.mark.parametrize(
    ("mesh", "told"),
    [
        ("../secret.obj", "lies outside the submission's folder"),
        ("link/secret.obj", "lies outside"),
        ("/etc/passwd", "lies outside"),
        ("..\\\\secret.obj", "lies outside"),
        ("missing.glb", "is no GLB or OBJ"),
        ("chair.ply", "is no GLB or OBJ"),
        ("broken.obj", "has no mesh"),
        ("broken.glb", "has no mesh"),
        ("large.obj", "of 50 MB at most"),
    ],
)
def test_a_mesh_that_is_elsewhere_or_broken_is_told(tmp_path: Path, mesh: str, told: str) -> None:
    (tmp_path / "secret.obj").write_text("v 0 0 0")
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "link").symlink_to(tmp_path)
    for name in ("broken.obj", "broken.glb", "chair.ply"):
        (folder / name).write_text("v 0 0 0")
    with (folder / "large.obj").open("wb") as large:
        large.truncate(plain.LARGEST + 1)  # takes no disk
    assert told in write_thing(folder, mesh).unread["toy_room_1"]


def write_usd(folder: Path, up: str = "Z", unit: float = 1.0) -> Path:
    """The room as a stage: a cube, a cylinder, a mesh."""
    from pxr import Gf, Usd, UsdGeom

    path = folder / "toy_room_1.usda"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    base = np.diag([*[1 / unit] * 3, 1]) @ (np.eye(4) if up == "Z" else Y_UP)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())

    def place(prim: Any, pose: Any) -> None:
        UsdGeom.Xformable(prim).AddTransformOp().Set(Gf.Matrix4d((base @ pose).T.tolist()))

    box = trimesh.creation.box(CABINET.size)
    for thing in (TABLE, MUG, CABINET):
        top = UsdGeom.Xform.Define(stage, f"/World/thing_{thing.number}")
        top.GetPrim().SetCustomDataByKey("category", NAMES[thing.label])
        place(top, pose_of(thing))
        at = f"/World/thing_{thing.number}/visual"
        if thing is TABLE:
            cube = UsdGeom.Cube.Define(stage, at)
            cube.CreateSizeAttr(1.0)
            UsdGeom.Xformable(cube).AddScaleOp().Set(Gf.Vec3f(*thing.size))
        elif thing is MUG:
            tube = UsdGeom.Cylinder.Define(stage, at)
            tube.CreateRadiusAttr(0.05)
            tube.CreateHeightAttr(0.1)
        else:
            mesh = UsdGeom.Mesh.Define(stage, at)
            mesh.CreatePointsAttr(box.vertices.tolist())
            mesh.CreateFaceVertexCountsAttr([3] * len(box.faces))
            mesh.CreateFaceVertexIndicesAttr(box.faces.ravel().tolist())
        guide = UsdGeom.Cube.Define(stage, f"/World/thing_{thing.number}/collision")  # larger, and not shown
        guide.CreatePurposeAttr("guide")
    UsdGeom.Cube.Define(stage, "/World/floor")
    place(UsdGeom.Camera.Define(stage, "/World/camera"), POSE @ OPENGL)
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize(("up", "unit"), [("Z", 1.0), ("Y", 0.01)])
def test_a_usd_stage(tmp_path: Path, up: str, unit: float) -> None:
    write_usd(tmp_path, up, unit)
    submission = read(tmp_path)
    check(submission)
    assert len(submission.rooms["toy_room_1"].room.things) == 3, "the floor is none"


@pytest.mark.parametrize(
    "line",
    [
        'def "a" (references = @../secret.usda@) {}',
        'def "a" (payload = @other.usda@) {}',
        'def "a" (clips = {dictionary default = {asset[] assetPaths = [@/etc/passwd@]}}) {}',
    ],
)
def test_a_usd_stage_of_several_files_is_refused(tmp_path: Path, line: str) -> None:
    path = write_usd(tmp_path)
    path.write_text(f"{path.read_text()}\n{line}\n")
    assert "names other layers" in read(tmp_path).unread["toy_room_1"]


@pytest.mark.parametrize(
    ("without", "told"), [("thing", "has no prim that is a thing"), ("camera", "has no camera called 'camera'")]
)
def test_a_usd_stage_without_things_or_camera_is_told(tmp_path: Path, without: str, told: str) -> None:
    from pxr import Usd

    stage = Usd.Stage.Open(str(write_usd(tmp_path)))
    for prim in stage.GetPrimAtPath("/World").GetChildren():
        if prim.GetName().startswith(without):
            stage.RemovePrim(prim.GetPath())
    stage.Save()
    assert told in read(tmp_path).unread["toy_room_1"]
