"""URDFs, meshes, notes and folders that cannot be used: one line with file and element, and nothing half-written."""

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from roomkin.plugins.importing.tests.own_models import import_folder
from roomkin.stages.articulated.mesh_reader import load_meshes
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.contracts.errors import InputError
from tests.unit.articulated_models import CABINET, write_cabinet

BODY_BOX = '<box size="0.4 0.6 0.8"/>'
BODY_MASS = '<mass value="12"/>'
INERTIA = 'ixx="1"'
AXIS = '<axis xyz="0 0 -1"/>'
HINGE = 'lower="-1.5" upper="0"'
SLIDE = 'lower="0" upper="0.2"'
SPHERE = '<sphere radius="0.02"/>'
END = "</robot>"
DEEP = "<a>" * 50_000 + "</a>" * 50_000
BOMB = "<!DOCTYPE r [" + "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10)) + "]>"
CYCLE = (
    '<link name="a"/><link name="b"/>'
    '<joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>'
    '<joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint></robot>'
)
CHAIN = "".join(f'<link name="l{k}"/>' for k in range(1001))


def fixed(parent: str, child: str, name: str = "extra") -> str:
    return f'<joint name="{name}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint></robot>'


def mesh(filename: str, more: str = "") -> str:
    return f'<mesh filename="{filename}"{more}/>'


BROKEN_XML = [
    (CABINET, "", "is not XML"),
    (CABINET, "not xml at all", "is not XML"),
    (CABINET, "<robot/>", "has no <link>"),
    (CABINET, "<mujoco/>", "has <mujoco> at the top"),
    (END, '<xacro:d n="1"/></robot>', "it is xacro"),
    (CABINET, '<sdf><robot name="x"/></sdf>', "has <sdf> at the top"),
    (END, "", "is not XML"),
    ("<robot", '<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/hostname">]><robot', "DOCTYPE"),
    ("<robot", BOMB + "<robot", "DOCTYPE"),
    ("<robot", BOMB.replace("DOC", "DOC<!-- -->") + "<robot", "DOCTYPE"),
    ("<robot", BOMB.replace("DOC", 'DOC xmlns=""') + "<robot", "DOCTYPE"),
    (END, "<!--" * 100_000, "is not XML"),
    ('"tray"', '"&undefined;"', "is not XML"),
    (CABINET, f"<robot>{DEEP}</robot>", "has no <link>"),
    (CABINET, "<robot>" * 20_000, "is not XML"),
    (CABINET, CABINET.replace("cabinet", "cab\x00inet"), "is not XML"),
]
BROKEN_TREE = [
    (END, CYCLE, "joint 'ab' is part of a cycle"),
    ('<child link="tray"/>', '<child link="body"/>', "joint 'slide': link 'body' is its own parent"),
    ('<child link="tray"/>', '<child link="door"/>', "link 'door' is the child of 2 joints"),
    (
        '<parent link="body"/><child link="tray"/>',
        '<parent link="tray"/><child link="tray"/>',
        "'tray' is its own parent",
    ),
    (END, '<link name="loose"/></robot>', "2 have no parent"),
    (END, fixed("door", "body"), "0 have no parent"),
    (END, '<link name="door"/></robot>', "has 2 links called 'door'"),
    (END, "<link/></robot>", "a <link> has no name"),
    ('<link name="tray">', '<link name=" ">', "a <link> has no name"),
    ('name="slide"', 'name="hinge"', "has 2 joints called 'hinge'"),
    ('<joint name="slide"', "<joint", "a <joint> has no name"),
    ('<child link="door"/>', '<child link="gate"/>', "joint 'hinge': <child> names no link"),
    ('<child link="door"/>', "", "joint 'hinge': <child> names no link"),
    ('<parent link="door"/>', "<parent/>", "joint 'knob': <parent> names no link"),
    (END, CHAIN + END, "has 1005 links"),
]
BROKEN_JOINTS = [
    ('<origin xyz="0.2 0.3 0.4"/>', '<origin xyz="0.2 0.3"/>', "joint 'hinge': xyz"),
    ('<origin xyz="0.2 0.3 0.4"/>', '<origin xyz="0.2 0.3 0.4" rpy="a b c"/>', "joint 'hinge': rpy"),
]
FIXED_JOINTS = [  # what cannot be used of a joint, and what is said; the model can
    ('type="prismatic"', 'type="spherical"', "joint 'slide': type 'spherical' is not supported"),
    (' type="prismatic"', "", "joint 'slide': type '' is not supported"),
    (AXIS, '<axis xyz="0 0 0"/>', "joint 'hinge': its axis is zero"),
    (AXIS, '<axis xyz="0 1"/>', "joint 'hinge': xyz=\"0 1\" is not 3 number"),
    (AXIS, '<axis xyz="0 0 nan"/>', "joint 'hinge': xyz"),
    (AXIS, '<axis xyz="0 0 -1e30"/>', "joint 'hinge': xyz=\"0 0 -1e30\" is not within"),
    (f'<limit {HINGE} effort="1" velocity="1"/>', "", "joint 'hinge': a revolute joint without <limit>"),
    (HINGE, 'lower="nan" upper="0"', "joint 'hinge': lower"),
    (HINGE, 'lower="-inf" upper="inf"', "joint 'hinge': lower"),
    (HINGE, 'lower="-1e30" upper="1e30"', "joint 'hinge': lower=\"-1e30\" is not within"),
    (HINGE, 'lower="0" upper="720"', "joint 'hinge': limits 0 and 720 are more than two full turns"),
    (HINGE, 'lower="" upper="0"', "joint 'hinge': lower=\"\" is not 1 number"),
    (HINGE, 'lower="0" upper="0"', "joint 'hinge': has no range (0 to 0)"),
    (SLIDE, 'lower="0" upper="0,2"', "joint 'slide': upper=\"0,2\""),
]
MENDED_JOINTS = [
    (HINGE, 'lower="0" upper="-1.5"', "joint 'hinge': limits upside down (0, -1.5), taken the other way round"),
    (SLIDE, 'lower="0.2" upper="0"', "joint 'slide': limits upside down (0.2, 0), taken the other way round"),
    ('xyz="0.2 0.3 0.4"', 'xyz="0.2 0.3 0.4 0"', "joint 'hinge': xyz=\"0.2 0.3 0.4 0\" is more than 3 numbers"),
    (HINGE, 'lower="-86" upper="0"', "joint 'hinge': limits -86 and 0, taken for degrees"),
]
BROKEN_LINKS = [
    (BODY_BOX, '<box size="0.4 wide"/>', "link 'body', <visual>: size"),
    (BODY_BOX, "<box/>", "link 'body', <visual>: size"),
    (BODY_BOX, '<box size="0.4 -0.6 0.8"/>', "link 'body', <visual>: size=\"0.4 -0.6 0.8\" must be positive"),
    (BODY_BOX, '<box size="0.4 0 0.8"/>', "link 'body', <visual>: size"),
    (BODY_BOX, '<sphere radius="-1"/>', "link 'body', <visual>: radius=\"-1\" must be positive"),
    (BODY_BOX, '<cylinder radius="1"/>', "link 'body', <visual>: length"),
    (BODY_BOX, '<capsule radius="inf" length="1"/>', "link 'body', <visual>: radius"),
    (BODY_BOX, '<cone radius="1" length="1"/>', "<cone> is not a known geometry"),
    (BODY_BOX, "", "link 'body', <visual>: has no <geometry>"),
    (f"<geometry>{BODY_BOX}</geometry>", "", "link 'body', <visual>: has no <geometry>"),
    (CABINET, '<robot><link name="empty"/></robot>', "shows nothing"),
]
DOUBTED_LINKS = [  # of which the model can do without
    (BODY_MASS, '<mass value="-3"/>', "link 'body', <mass>: value"),
    (BODY_MASS, '<mass value="inf"/>', "link 'body', <mass>: value"),
    (BODY_MASS, '<mass value="1e30"/>', "link 'body', <mass>: value"),
    (BODY_MASS, '<mass value="a lot"/>', "link 'body', <mass>: value"),
    (INERTIA, 'ixx="nan"', "link 'body', <inertia>: ixx"),
    (INERTIA, 'ixx="1e30"', "link 'body', <inertia>: ixx"),
    (
        'rgba="0.5 0.3 0.1 1"',
        'rgba="128 80 30 255"',
        "link 'body', <visual>: rgba=\"128 80 30 255\" is above 1, taken for bytes",
    ),
    ('rgba="0.5 0.3 0.1 1"', 'rgba="0.5 0.3 0.1"', "link 'body', <visual>: rgba"),
    ('rgba="0.5 0.3 0.1 1"', 'rgba="-1 0.3 0.1 1"', "link 'body', <visual>: rgba"),
]
BROKEN_MESHES = [
    (mesh("gone.obj"), "link 'body', <visual>: there is no mesh 'gone.obj'"),
    (mesh(""), "there is no mesh ''"),
    ("<mesh/>", "there is no mesh ''"),
    (mesh("."), "there is no mesh '.'"),
    (mesh("a" * 5000 + ".obj"), "there is no mesh 'aaa"),
    (mesh("loop.obj"), "there is no mesh 'loop.obj'"),
    (mesh("../../../secret.obj"), "there is no mesh '../../../secret.obj' in mine/"),
    (mesh("package://../../../../secret.obj"), "secret.obj' in mine/"),
    (mesh("link.obj"), "there is no mesh 'link.obj' in mine/, but a link out of it. Fix: copy there what it links to"),
    (mesh("../linked/secret.obj"), "there is no mesh '../linked/secret.obj' in mine/, but a link out of it"),
    (mesh("file:///etc/hostname"), "there is no mesh 'etc/hostname'"),
    (mesh("bad.obj"), "bad.obj: "),
    (mesh("empty.obj"), "empty.obj: "),
    (mesh("points.obj"), "points.obj: "),
    (mesh("no_area.obj"), "no_area.obj: holds no triangles that have an area"),
    (mesh("nan.obj"), "nan.obj: "),
    (mesh("far.obj"), "far.obj: has coordinates"),
    (mesh("index.obj"), "index.obj: "),
    (mesh("short.stl"), "short.stl: "),
    (mesh("short.glb"), "short.glb: cannot be read as a mesh"),
    (mesh("no.dae"), "no.dae: cannot be read as a mesh"),
    (mesh("model.blend"), "'.blend' is not a mesh file"),
    (mesh("good.obj", ' scale="1 1"'), "link 'body', <visual>: scale"),
    (mesh("good.obj", ' scale="0 1 1"'), "link 'body', <visual>: scale=\"0 1 1\" flattens"),
    (mesh("good.obj", ' scale="nan 1 1"'), "link 'body', <visual>: scale"),
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A user's folder with one cabinet."""
    write_cabinet(tmp_path / "mine")
    return tmp_path / "mine"


def broken_meshes(place: Path, outside: Path) -> None:
    trimesh.creation.box().export(outside / "secret.obj")
    trimesh.creation.box().export(place / "good.obj")
    (place / "link.obj").symlink_to(outside / "secret.obj")
    (place.parent / "linked").symlink_to(outside)
    (place / "loop.obj").symlink_to(place / "loop.obj")
    for name, text in {
        "bad.obj": "this is not a mesh",
        "empty.obj": "",
        "points.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "no_area.obj": "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n",
        "nan.obj": "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "far.obj": "v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "index.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
        "no.dae": "<COLLADA/>",
        "model.blend": "BLENDER",
    }.items():
        (place / name).write_text(text)
    (place / "short.stl").write_bytes(b"\0" * 80 + struct.pack("<I", 1000) + b"\0" * 50)
    (place / "short.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 4000))


def refused(folder: Path, complaint: str) -> None:
    """The folder is refused with one line, and nothing is left of it."""
    models = folder.parent / "models"
    with pytest.raises(InputError, match=complaint) as caught:
        import_folder(folder, models)
    assert "\n" not in str(caught.value)
    assert str(folder) in str(caught.value), "the file is named"
    assert len(str(caught.value)) < 600
    assert not models.exists() or not list(models.iterdir())


@pytest.mark.parametrize(("old", "new", "complaint"), BROKEN_XML + BROKEN_TREE + BROKEN_JOINTS + BROKEN_LINKS)
def test_broken_urdf_is_one_clear_line(folder: Path, old: str, new: str, complaint: str) -> None:
    assert old in CABINET
    (folder / "bottom_cabinet" / "Oak 1" / "cab.urdf").write_text(CABINET.replace(old, new, 1))
    refused(folder, complaint)


@pytest.mark.parametrize(("geometry", "complaint"), BROKEN_MESHES)
def test_broken_mesh_is_one_clear_line(folder: Path, geometry: str, complaint: str) -> None:
    place = folder / "bottom_cabinet" / "Oak 1"
    broken_meshes(place, folder.parent)
    (place / "cab.urdf").write_text(CABINET.replace(BODY_BOX, geometry))
    refused(folder, complaint)


@pytest.mark.parametrize(("old", "new", "said"), FIXED_JOINTS + MENDED_JOINTS + DOUBTED_LINKS)
def test_what_a_model_can_do_without_is_said(folder: Path, old: str, new: str, said: str) -> None:
    assert old in CABINET
    path = folder / "bottom_cabinet" / "Oak 1" / "cab.urdf"
    path.write_text(CABINET.replace(old, new, 1))
    robot = read_urdf(path, folder)
    assert [said in remark for remark in robot.remarks] == [True]
    fixed = (old, new, said) in FIXED_JOINTS
    assert {joint.name for joint in robot.joints if joint.type != "fixed"} == (
        {"hinge", "slide"} - ({said.split("'")[1]} if fixed else set())
    )
    spans = {"hinge": 1.5, "slide": 0.2}
    for joint in robot.joints:
        if joint.type != "fixed":
            assert joint.upper - joint.lower == pytest.approx(spans[joint.name], abs=0.002)
    assert all(0.01 <= link.mass <= 1000 and np.isfinite(link.inertia).all() for link in robot.links.values())


def test_a_slide_of_kilometres_is_cut(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "bottom_cabinet" / "Oak 1" / "cab.urdf"
    path.write_text(CABINET.replace(SLIDE, 'lower="0" upper="5000"'))
    (entry,) = import_folder(folder, folder.parent / "models")
    assert [joint.name for joint in entry.joints] == ["hinge", "slide"]
    assert 0.2 < entry.joints[1].upper - entry.joints[1].lower <= entry.size[0]
    assert "drawer 'slide' slides 5e+05 cm in its file, cut to " in capsys.readouterr().out


def test_a_part_that_cannot_be_shown_is_left_out(folder: Path) -> None:
    path = folder / "bottom_cabinet" / "Oak 1" / "cab.urdf"
    for old, new in ((SPHERE, '<sphere radius="0"/>'), (SPHERE, mesh("gone.obj")), (SPHERE, mesh("../../../s.obj"))):
        path.write_text(CABINET.replace(old, new))
        robot = read_urdf(path, folder)
        assert not robot.links["door_knob"].visuals
        (remark,) = robot.remarks
        assert remark.startswith("left out: link 'door_knob', <visual>: ")
    door = '<visual><origin xyz="0.01 -0.29 0"/>'
    path.write_text(CABINET.replace(door, f"<visual><geometry>{mesh('gone.obj')}</geometry></visual>{door}"))
    assert len(read_urdf(path, folder).links["door"].visuals) == 1, "another shape of the link remains"
    path.write_text(CABINET.replace(SPHERE, mesh("gone.obj")).replace('<box size="0.2 0.1 0.05"/>', mesh("gone.obj")))
    refused(folder, "link 'door_knob', <visual>: there is no mesh 'gone.obj'")  # half of what is seen


NOTES = [
    ("{", "breaks the Notes contract"),
    ("[]", "breaks the Notes contract"),
    ('{"color": "red"}', "color"),
    ('{"scale": 0}', "scale"),
    ('{"scale": -1}', "scale"),
    ('{"scale": 1e999}', "scale"),
    ('{"scale": "inf"}', "scale"),
    ('{"scale": NaN}', "asset.json"),
    ('{"scale": 500}', "is .* m large. Fix: at most 30 m"),
    ('{"scale": 1e-5}', "is flat"),
    ('{"mass": -1}', "mass"),
    ('{"mass": "Infinity"}', "mass"),
    ('{"mass": 1e30}', "mass"),
    ('{"front": "north"}', "front"),
    ('{"front": "+z"}', "front [+]z and up [+]z lie along one line"),
    ('{"front": "-x", "up": "+x"}', "lie along one line"),
    ('{"placement": "ceiling"}', "placement"),
    ('{"symmetry": "some"}', "symmetry"),
    ('{"category": 3}', "category"),
    ("\x00", "asset.json"),
]
UNBELIEVABLE = [
    (BODY_BOX, '<box size="400 0.6 0.8"/>', "is 400 x .* m large"),
    (BODY_BOX, '<box size="1000000 1000000 1000000"/>', "m large"),
    ('<origin xyz="0 0 0.4"/>', '<origin xyz="0 0 900000"/>', "m large"),
]


@pytest.mark.parametrize(("notes", "complaint"), NOTES)
def test_broken_notes_are_one_clear_line(folder: Path, notes: str, complaint: str) -> None:
    (folder / "bottom_cabinet" / "Oak 1" / "asset.json").write_text(notes)
    refused(folder, complaint)


@pytest.mark.parametrize(("old", "new", "complaint"), UNBELIEVABLE)
def test_models_larger_than_a_room_are_refused(folder: Path, old: str, new: str, complaint: str) -> None:
    assert old in CABINET
    (folder / "bottom_cabinet" / "Oak 1" / "cab.urdf").write_text(CABINET.replace(old, new, 1))
    refused(folder, complaint)


def test_a_urdf_that_is_no_text_or_no_file(folder: Path) -> None:
    path = folder / "bottom_cabinet" / "Oak 1" / "cab.urdf"
    path.write_bytes(b"\xe9" + CABINET.encode())
    refused(folder, "is no UTF-8 text")
    path.unlink()
    path.mkdir()
    refused(folder, "holds no model")
    with pytest.raises(InputError, match=r"cannot be read .is a directory"):
        read_urdf(path, folder)
    with pytest.raises(InputError, match=r"cannot be read .no such file or directory"):
        read_urdf(path / "gone.urdf", folder)


def test_a_broken_rigid_mesh_is_one_clear_line(tmp_path: Path) -> None:
    place = tmp_path / "mine" / "mug"
    place.mkdir(parents=True)
    flat = trimesh.Trimesh(np.eye(3), [[0, 1, 2]]).apply_transform(trimesh.geometry.align_vectors([1, 1, 1], [0, 0, 1]))
    for name, write, complaint in [
        ("a.glb", lambda path: path.write_bytes(b"glTF"), "a.glb: cannot be read as a mesh"),
        ("a.obj", lambda path: path.write_text("v 1 2 3"), "a.obj: "),
        ("a.obj", flat.export, "is flat"),
        ("a.obj", trimesh.creation.box([40, 1, 1]).export, "40 x 1 x 1 m large"),
    ]:
        write(place / name)
        refused(tmp_path / "mine", complaint)
        (place / name).unlink()


def test_names_that_are_taken_are_numbered(folder: Path, tmp_path: Path) -> None:
    for place, text in (("Oak 2", CABINET), ("oak-1", CABINET.replace("0.5 0.3 0.1 1", "0.1 0.1 0.1 1"))):
        (folder / "bottom_cabinet" / place).mkdir()
        (folder / "bottom_cabinet" / place / "cab.urdf").write_text(text)
    assets = import_folder(folder, tmp_path / "models", taken=["bottom_cabinet_oak_1"])
    assert [asset.id for asset in assets] == [
        "bottom_cabinet_oak_1_2", "bottom_cabinet_oak_2", "bottom_cabinet_oak_1_3"
    ]  # fmt: skip
    assert len({asset.checksum for asset in assets}) == 2, "the second is a copy"
    assert {path.name for path in (tmp_path / "models").iterdir()} == {asset.id for asset in assets}


def test_one_broken_model_leaves_the_others_whole(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = folder / "bottom_cabinet" / "Oak 2"
    again.mkdir()
    (again / "door.urdf").write_text(CABINET.replace(BODY_BOX, mesh("gone.obj")))
    (asset,) = import_folder(folder, tmp_path / "models")
    assert "door.urdf: link 'body'" in capsys.readouterr().out
    assert [path.name for path in (tmp_path / "models").iterdir()] == [asset.id] == ["bottom_cabinet_oak_1"]
    assert (tmp_path / "models" / asset.id / "asset.json").exists()


def test_elements_that_are_not_read_are_named(tmp_path: Path) -> None:
    folder = write_cabinet(tmp_path)
    file = next(folder.rglob("*.urdf")) if folder.is_dir() else folder
    file.write_text(file.read_text().replace(END, "<include/><include/></robot>"))
    assert "not read: <include> (2)" in read_urdf(file, tmp_path).remarks


def test_a_decimal_comma_is_told(tmp_path: Path) -> None:
    lines = "facet normal 0 0 1\n outer loop\n" + "  vertex 0,5 0,1 0,0\n" * 3 + " endloop\nendfacet\n"
    (tmp_path / "a.stl").write_text(f"solid a\n{lines}endsolid a\n")
    with pytest.raises(InputError, match=r"decimal comma.*decimal point"):
        load_meshes(tmp_path / "a.stl", tmp_path)
