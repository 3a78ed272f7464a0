"""Scenes of other formats: boxes of a size, at a place and a turn that are known."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from roomkin.plugins.scorecard import placing, reading, scoring
from roomkin.plugins.scorecard.readers import mjcf, solid
from roomkin.plugins.scorecard.submission import Submission
from roomkin.plugins.scorecard.tests.rooms import CABINET, HEAD, MUG, POSE, TABLE, TRUTH
from roomkin.plugins.scorecard.truth import TrueThing
from roomkin.stages.geometry.cameras import OPENGL
from roomkin.stages.geometry.frames import Y_UP, invert_transform, make_transform, yaw_matrix
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
        assert submission.rooms["toy_room_1"].cells[0].all()  # a box is filled
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
        ("toy_room_1.usd", b"PXR", "has a format that is not read. Fix: one of JSON, GLB, XML"),
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
