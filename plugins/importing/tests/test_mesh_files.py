"""OBJ and DAE: shape, size, colors and pictures as their files say them, or a line."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.importing.importers.dae import read_dae
from roomkin.stages.articulated.mesh_files.obj import split, triangles_of
from roomkin.stages.articulated.mesh_reader import has_texture, load_meshes
from roomkin.stages.articulated.urdf_reader import read_urdf
from tests.refusals import refused

U_SHAPE = np.array([[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]], dtype=float)  # 7 square metres
ARROW = np.array([[0, 0], [4, 4], [0, 1], [-4, 4]], dtype=float)  # its notch is seen from its tip alone


def read(path: Path, folder: Path) -> tuple[list[Any], list[str]]:
    meshes, lost = load_meshes(path, folder)
    return list(meshes), lost


def put(flat: np.ndarray, normal: tuple[float, ...]) -> np.ndarray:
    """Corners (N, 3) of a polygon in the plane of a normal, turned counter-clockwise as seen from there."""
    z = np.array(normal) / np.linalg.norm(normal)
    x = np.cross([0.3, 1.0, -0.2], z)
    x /= np.linalg.norm(x)
    return flat @ np.array([x, np.cross(z, x)])


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, -1, 0), (1, 2, -3)])
@pytest.mark.parametrize("first", [0, 3])
@pytest.mark.parametrize("shape", ["u", "arrow"])
def test_polygons_of_any_shape_are_filled_and_face_their_way(normal: tuple[float, ...], first: int, shape: str) -> None:
    corners = put(np.roll(U_SHAPE if shape == "u" else ARROW, first, axis=0), normal)
    one, two, three = corners[triangles_of(corners)].transpose(1, 0, 2)
    areas = np.cross(two - one, three - one) / 2
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(7.0 if shape == "u" else 4.0)
    assert (areas @ np.array(normal) > 0).all()


def test_holes_that_a_bridge_leads_to_stay_open() -> None:
    rim, hole = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0)], [(1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
    corners = put(np.array(rim + hole, dtype=float), (1, 2, 3))
    one, two, three = corners[triangles_of(corners)].transpose(1, 0, 2)
    assert np.linalg.norm(np.cross(two - one, three - one) / 2, axis=1).sum() == pytest.approx(12)


def test_convex_polygons_are_fans_and_lines_are_nothing() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    faces, polygons = split(square, [np.array([0, 1]), np.array([3, 0, 1, 2]), np.array([0, 1, 2])])
    assert faces.tolist() == [[3, 0, 1], [3, 1, 2], [0, 1, 2]]
    assert polygons.tolist() == [1, 1, 2]


def u_obj(backwards: bool = False) -> str:
    """A U-shaped board of 1 m depth: 2 x 7 square metres of faces, and a rim."""
    corners = np.concatenate([np.c_[U_SHAPE, np.zeros(8)], np.c_[U_SHAPE, np.ones(8)]])
    faces = [[*range(8, 16)], [*range(7, -1, -1)], *([k, (k + 1) % 8, (k + 1) % 8 + 8, k + 8] for k in range(8))]
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in corners]
    lines += ["f " + " ".join(str(k - 16 if backwards else k + 1) for k in face) for face in faces]
    return "\n".join([*lines, "v 9 9 9", ""])


@pytest.mark.parametrize("backwards", [False, True])
def test_concave_faces_of_objs_stay_open(tmp_path: Path, backwards: bool) -> None:
    (tmp_path / "a.obj").write_text(u_obj(backwards))
    (mesh,), lost = read(tmp_path / "a.obj", tmp_path)
    assert mesh.area == pytest.approx(14 + 16), "its rim is 16 m long"
    assert mesh.volume == pytest.approx(7.0)
    assert not lost


def test_faces_that_name_corners_that_are_not_there_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 5\n")
    with refused("E-MESH-BROKEN", "a face names corners that are not among the 4 of the file"):
        read(tmp_path / "a.obj", tmp_path)


TETRAHEDRON = "f 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"
PLACED = "f 1/1 2/1 3/1\nf 1/1 2/1 4/1\nf 2/1 3/1 4/1\nf 1/1 3/1 4/1\n"


def test_colors_of_an_objs_corners_are_its_looks_unless_a_picture_is(tmp_path: Path) -> None:
    corners = [f"v {x} {y} {z} 1 0.5 0" for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))]
    text = "\n".join(["mtllib a.mtl", *corners, "vt 0 0", "usemtl grey", TETRAHEDRON])
    (tmp_path / "a.obj").write_text(text)
    (tmp_path / "a.mtl").write_text("newmtl grey\nKd 0.75 0.75 0.75\n")
    (mesh,), lost = read(tmp_path / "a.obj", tmp_path)
    assert np.unique(mesh.visual.vertex_colors, axis=0).tolist() == [[255, 128, 0, 255]]
    assert not lost
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    (tmp_path / "a.mtl").write_text("newmtl grey\nmap_Kd a.png\n")
    (tmp_path / "a.obj").write_text(text.replace(TETRAHEDRON, PLACED))
    assert has_texture(read(tmp_path / "a.obj", tmp_path)[0][0])


MATERIALS = [
    ("Kd 0.2 0.4 0.6\nd 0.25", [51, 102, 153, 64], ""),
    ("Kd 0.2 0.4 0.6\nTr 0.25", [51, 102, 153, 191], ""),
    ("Kd 0.2 0.4 0.6\nd -halo 1", [51, 102, 153, 255], ""),
    ("Kd 0.2 0.4 0.6\nTr 1", [51, 102, 153, 255], ""),
    ("Kd 0 0 0\nmap_Kd a.png", [255] * 4, "a.mtl: 'wood' would paint its picture black: its color is not used"),
    ("map_Kd a.png", [255] * 4, ""),
    ("Kd 1 1 1\nmap_d a.png", [255] * 4, "a.mtl: pictures of transparency (map_d of wood) are not read"),
]


@pytest.mark.parametrize(("lines", "color", "says"), MATERIALS)
def test_materials_of_objs(tmp_path: Path, lines: str, color: list[int], says: str) -> None:
    Image.new("RGB", (2, 2), (200, 100, 0)).save(tmp_path / "a.png")
    (tmp_path / "a.mtl").write_text(f"newmtl wood\nKs 0 0 0\n{lines}\n")
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nusemtl wood\n{PLACED}")
    (mesh,), lost = read(tmp_path / "a.obj", tmp_path)
    material = mesh.visual.material.to_pbr()
    assert material.baseColorFactor.tolist() == color
    assert (material.baseColorTexture is not None) == ("map_Kd" in lines)
    assert lost == [says] * bool(says)


def test_pictures_that_no_face_places_and_shapes_that_are_no_triangles_are_told(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    (tmp_path / "a.mtl").write_text("newmtl wood\nKd 1 0 0\nmap_Kd a.png\n")
    corners = "v\t0 0 0\nv\t1 0 0\nv\t0 1 0\nv\t0 0 1\nvt 0 0\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{corners}usemtl wood\nf\t1/1 2/1 3/1\nf 1 2 4\n")
    (mesh,), lost = read(tmp_path / "a.obj", tmp_path)
    assert mesh.visual.material.to_pbr().baseColorFactor.tolist() == [255, 0, 0, 255]
    assert not has_texture(mesh)
    assert lost == ["a.obj is shown without a picture that it places nowhere"]
    (tmp_path / "a.obj").write_text(f"{corners}cstype bspline\nsurf 0 1 0 1 1 2 3 4\n")
    with refused("E-MESH-BROKEN", "no triangles that have an area: a.obj: its free-form surfaces are not read"):
        read(tmp_path / "a.obj", tmp_path)


def test_pictures_of_objs_are_scaled_and_shifted(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2)).save(tmp_path / "my wood.png")
    (tmp_path / "a.mtl").write_text("newmtl wood\nmap_Kd -blendu on -s 2 3 1 -o 0.5 -bm 1.0 my wood.png\n")
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{corners}usemtl wood\nf 1/1 2/2 3/3\n")
    (mesh,), lost = read(tmp_path / "a.obj", tmp_path)
    assert has_texture(mesh) and not lost
    assert sorted(mesh.visual.uv.tolist()) == [[0.5, 0], [0.5, 3], [2.5, 0]]


def test_several_material_files_and_materials_in_none(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl one\nKd 1 0 0\n")
    (tmp_path / "b.mtl").write_text("newmtl two\nKd 0 1 0\n")
    faces = "usemtl one\nf 1 2 3\nusemtl two\nf 1 2 4\nusemtl three\nf 2 3 4\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{faces}l 1 2\n")
    meshes, lost = read(tmp_path / "a.obj", tmp_path)
    assert len(meshes) == 3
    assert lost == [
        "a.obj: 1 of its materials ('three') are in no material file: shown grey",
        "a.obj: its lines are not read",
    ]


def dae(shape: str, unit: str = '<unit meter="0.0254"/>', up: str = "<up_axis>Z_UP</up_axis>", more: str = "") -> str:
    """A U-shaped board, 3 x 3 units and 1 high, at x = 10."""
    corners = np.concatenate([np.c_[U_SHAPE, np.zeros(8)], np.c_[U_SHAPE, np.ones(8)]])
    faces = [[*range(8, 16)], [*range(7, -1, -1)], *([k, (k + 1) % 8, (k + 1) % 8 + 8, k + 8] for k in range(8))]
    numbers, indices = " ".join(f"{x:g}" for x in corners.ravel()), [" ".join(map(str, face)) for face in faces]
    inputs = '<input semantic="VERTEX" source="#v" offset="0"/>'
    if shape == "polylist":
        counts = f"<vcount>{' '.join(str(len(face)) for face in faces)}</vcount>"
        inside = f"<polylist count='{len(faces)}'>{inputs}{counts}<p>{' '.join(indices)}</p></polylist>"
    else:
        inside = f"<polygons>{inputs}{''.join(f'<p>{face}</p>' for face in indices)}</polygons>"
    accessor = '<technique_common><accessor source="#pa" count="16" stride="3"><param name="X" type="float"/>'
    accessor += '<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>'
    instance = '<instance_geometry url="#g"/>' if not more else '<instance_controller url="#c"/>'
    return (
        f'<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{unit}{up}</asset>'
        f'<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="48">{numbers}'
        f'</float_array>{accessor}</source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{inside}'
        f"</mesh></geometry></library_geometries>{more}<library_visual_scenes><visual_scene id='s'><node>"
        f"<translate>10 0 0</translate>{instance}</node></visual_scene></library_visual_scenes>"
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


@pytest.mark.parametrize("shape", ["polylist", "polygons"])
def test_collada_is_in_metres_and_its_polygons_stay_open(tmp_path: Path, shape: str) -> None:
    (tmp_path / "a.dae").write_text(dae(shape))
    (mesh,), lost = read(tmp_path / "a.dae", tmp_path)
    assert mesh.bounds / 0.0254 == pytest.approx(np.array([[10, 0, 0], [13, 3, 1]]))
    assert mesh.area / 0.0254**2 == pytest.approx(30)
    assert not lost


@pytest.mark.parametrize(
    ("up", "extents"), [("Z_UP", (3, 3, 1)), ("Y_UP", (1, 3, 3)), ("", (1, 3, 3)), ("X_UP", (1, 3, 3))]
)
def test_collada_alone_stands_as_its_file_says(tmp_path: Path, up: str, extents: tuple[float, ...]) -> None:
    (tmp_path / "a.dae").write_text(dae("polylist", unit="", up=f"<up_axis>{up}</up_axis>" if up else ""))
    (visual,) = read_dae(tmp_path / "a.dae", tmp_path).links["base"].visuals
    assert visual.mesh.extents == pytest.approx(extents)
    assert visual.mesh.volume == pytest.approx(7), "not mirrored"
    low = {"Z_UP": 0, "Y_UP": 0, "": 0, "X_UP": 10}[up]
    assert visual.mesh.bounds[0, 2] == pytest.approx(low), "its foot is below"


def test_collada_inside_a_urdf_is_scaled_and_not_turned(tmp_path: Path) -> None:
    (tmp_path / "a.dae").write_text(dae("polylist", up="<up_axis>Y_UP</up_axis>"))
    mesh = '<visual><geometry><mesh filename="a.dae" scale="2"/></geometry></visual>'
    (tmp_path / "a.urdf").write_text(f'<robot name="r"><link name="a">{mesh}</link></robot>')
    robot = read_urdf(tmp_path / "a.urdf", tmp_path)
    assert robot.links["a"].visuals[0].mesh.extents / 0.0254 == pytest.approx((6, 6, 2))
    assert robot.remarks == ("a.dae says Y_UP: not turned, as a URDF's meshes never are (RViz)",)


def test_skins_of_collada_are_refused(tmp_path: Path) -> None:
    skin = '<library_controllers><controller id="c"><skin source="#g"/></controller></library_controllers>'
    (tmp_path / "a.dae").write_text(dae("polylist", more=skin))
    with refused("E-MESH-EXTENSION", "has skins or morph targets, not read here", "modifiers applied"):
        read(tmp_path / "a.dae", tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("0.0254", "0", "its unit is 0 metres"),
        ("<COLLADA", "<!DOCTYPE a><COLLADA", "declares a DOCTYPE"),
        ("<vcount>8", "<vcount>80", "counts 120 corners and has 48"),
        ("</scene>", "", "it is no XML"),
        ("<instance_visual_scene", "<instance_physics_scene", "it shows no scene"),
    ],
)
def test_broken_collada_is_one_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    (tmp_path / "a.dae").write_text(dae("polylist").replace(old, new))
    with refused("E-MESH-BROKEN", says):
        read(tmp_path / "a.dae", tmp_path)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_a_doctype_of_collada_is_seen_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "a.dae").write_text(f"<!DOCTYPE a>{dae('polylist')}", encoding=encoding)
    with refused("E-MESH-BROKEN", "declares a DOCTYPE"):
        read(tmp_path / "a.dae", tmp_path)


def test_one_scale_is_that_of_all_axes(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(u_obj())
    text = '<robot name="r"><link name="a"><visual><geometry><mesh filename="a.obj" scale="{}"/></geometry>'
    for scale, factors in (("0.5", (0.5, 0.5, 0.5)), (" 1 2 3 ", (1, 2, 3)), ("1 2 3 4", (1, 2, 3))):
        (tmp_path / "a.urdf").write_text(f"{text.format(scale)}</visual></link></robot>")
        robot = read_urdf(tmp_path / "a.urdf", tmp_path)
        assert robot.links["a"].visuals[0].mesh.extents == pytest.approx(np.array([3, 3, 1]) * factors)
    said = "link 'a', <visual>: scale=\"1 2 3 4\" is more than 3 numbers: the first 3 count"
    assert robot.remarks == (said,)


def test_names_in_other_alphabets_are_read(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_bytes("newmtl höl\nKd 1 0 0\n".encode("latin-1"))
    (tmp_path / "a.obj").write_bytes(
        f"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl höl\n{TETRAHEDRON}".encode("latin-1")
    )
    (mesh,), lost = read(tmp_path / "a.obj", tmp_path)
    assert mesh.visual.material.to_pbr().baseColorFactor.tolist() == [255, 0, 0, 255]
    assert not lost
