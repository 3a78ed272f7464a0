"""glTF: what moves, repeats or packs a mesh is worked out on reading, what cannot be is refused or told by name."""

import io
import json
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.exchange.gltf import extensions

from stages.articulated.mesh_reader import has_texture, load_meshes, texture_of
from stages.articulated.mesh_writer import write_glb
from tests.packages import needs
from tests.refusals import refused
from tests.unit.gltf_files import BOX, Gltf

pytestmark = needs("importing")

SIZE = (0.2, 0.4, 0.6)
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1.0]])


def read(file: Gltf, folder: Path) -> tuple[list[Any], list[str]]:
    return load_meshes(file.write(folder / "a.gltf"), folder)


def bounds(meshes: list[Any]) -> np.ndarray:
    corners = np.array([mesh.bounds for mesh in meshes])
    return np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])


@pytest.mark.parametrize(("kind", "normalized"), [("int8", True), ("uint16", True), ("int16", True), ("int16", False)])
def test_quantized_positions_have_their_size(tmp_path: Path, kind: str, normalized: bool) -> None:
    one = np.iinfo(kind).max if normalized else 100
    low = 0.0 if kind == "uint16" else -1.0
    shares = (BOX.vertices - BOX.bounds[0]) / BOX.extents * (1 - low) + low
    file = Gltf(extensionsRequired=["KHR_mesh_quantization"])
    primitive = file.box()
    primitive["attributes"]["POSITION"] = file.add((shares * one).round(), kind, normalized=normalized)
    scale = np.array(SIZE) / (1 - low) / (1 if normalized else one)
    file.show(primitive, scale=scale.tolist())
    meshes, lost = read(file, tmp_path)
    assert np.ptp(bounds(meshes), axis=0) == pytest.approx(SIZE, abs=1e-3)
    assert not lost


def test_instances_stand_where_they_are_put(tmp_path: Path) -> None:
    file = Gltf(extensionsRequired=["EXT_mesh_gpu_instancing"])
    places = [[0, 0, 0], [2, 0, 0], [0, 3, 0], [2, 3, 0]]
    turns = [[0, 0, 0, 127]] * 3 + [[0, 0, 90, 90]]
    told = {"TRANSLATION": file.add(places), "ROTATION": file.add(turns, "int8", normalized=True)}
    file.show(file.box(), extensions={"EXT_mesh_gpu_instancing": {"attributes": told}}, translation=[10, 0, 0])
    meshes, lost = read(file, tmp_path)
    extents = {tuple(mesh.bounds.mean(axis=0).round(6).tolist()): mesh.extents for mesh in meshes}
    assert extents.keys() == {(10 + x, y, z) for x, y, z in places}
    assert extents[10, 0, 0] == pytest.approx(SIZE)
    assert extents[12, 3, 0] == pytest.approx((0.4, 0.2, 0.6)), "a quarter turn about z"
    assert not lost


def test_skins_carry_their_mesh_to_the_joints(tmp_path: Path) -> None:
    file = Gltf()
    bind = np.eye(4)
    bind[:3, :3] *= 100.0  # the mesh is drawn in metres, its joints in centimetres
    joints, weights = file.add([[0, 0, 0, 0]] * 8, "uint8"), file.add([[1, 0, 0, 0]] * 8)
    inverse = file.add([bind.T.ravel()])
    file.show(file.box(JOINTS_0=joints, WEIGHTS_0=weights), skin=0, translation=[5, 5, 5])
    file.header["nodes"].append({"scale": [0.01] * 3, "translation": [1, 2, 3]})
    file.header["skins"] = [{"joints": [1], "inverseBindMatrices": inverse}]
    file.header["scenes"][0]["nodes"].append(1)
    (mesh,) = read(file, tmp_path)[0]
    assert mesh.extents == pytest.approx(SIZE)
    assert mesh.bounds.mean(axis=0) == pytest.approx((1, 2, 3)), "its own node does not count"


def test_morph_targets_and_sparse_numbers_count(tmp_path: Path) -> None:
    file = Gltf()
    longer = file.add(BOX.vertices * [1, 0, 0])
    primitive = file.box() | {"targets": [{"POSITION": longer}]}
    where, what = file.view(np.array([7], "<u2").tobytes()), file.view(np.array([[1, 1, 1]], "<f4").tobytes())
    accessor = file.header["accessors"][primitive["attributes"]["POSITION"]]
    accessor["sparse"] = {
        "count": 1, "indices": {"bufferView": where, "componentType": 5123}, "values": {"bufferView": what}
    }  # fmt: skip
    file.show(primitive, weights=[1.0])
    (mesh,) = read(file, tmp_path)[0]
    assert mesh.bounds[0] == pytest.approx((-0.2, -0.2, -0.3)), "twice as long"
    assert mesh.bounds[1] == pytest.approx((1.1, 1, 1)), "its last corner is put elsewhere"


@pytest.mark.parametrize(
    ("mode", "order", "area"), [(4, [0, 1, 2, 0, 2, 3], 1), (5, [0, 1, 3, 2], 1), (6, [0, 1, 2, 3], 1)]
)
def test_strips_and_fans_are_triangles_that_face_one_way(
    tmp_path: Path, mode: int, order: list[int], area: float
) -> None:
    file = Gltf()
    corners = {"attributes": {"POSITION": file.add(CORNERS)}, "indices": file.add(order, "uint8"), "mode": mode}
    (mesh,) = read(file.show(corners), tmp_path)[0]
    assert mesh.area == pytest.approx(area)
    assert mesh.face_normals == pytest.approx(np.array([[0, 0, 1], [0, 0, 1]]))


def picture(file: Gltf, **info: Any) -> dict[str, Any]:
    """A material with a picture: its upper left quarter is red, the rest blue."""
    data = io.BytesIO()
    pixels = np.full((8, 8, 3), (0, 0, 255), np.uint8)
    pixels[:4, :4] = (255, 0, 0)
    Image.fromarray(pixels).save(data, "PNG")
    file.header["images"] = [{"bufferView": file.view(data.getvalue()), "mimeType": "image/png"}]
    file.header["textures"] = [{"source": 0}]
    return {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **info}}}


@pytest.mark.parametrize(
    ("info", "within"),
    [
        ({"texCoord": 1}, (0, 0.5, 0.5, 1)),
        ({"extensions": {"KHR_texture_transform": {"scale": [0.5, 0.25]}}}, (0, 0.5, 0.75, 1)),
        ({"extensions": {"KHR_texture_transform": {"texCoord": 1, "offset": [0.5, 0]}}}, (0.5, 1, 0.5, 1)),
        # the specification's example: the lower left quarter
        (
            {"extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}}},
            (0, 0.5, 0, 0.5),
        ),
    ],
)
def test_pictures_lie_where_the_file_puts_them(tmp_path: Path, info: dict[str, Any], within: tuple[float, ...]) -> None:
    file = Gltf(extensionsUsed=["KHR_texture_transform"])
    whole = (BOX.vertices[:, :2] > 0).astype(float)
    primitive = file.box(TEXCOORD_0=file.add(whole), TEXCOORD_1=file.add(whole / 2)) | {"material": 0}
    file.header["materials"] = [picture(file, **info)]
    (mesh,), lost = read(file.show(primitive), tmp_path)
    u, v = mesh.visual.uv.T
    assert (u.min(), u.max(), v.min(), v.max()) == pytest.approx(within, abs=1e-6)
    assert texture_of(mesh) is not None
    assert not lost


def test_pictures_that_lie_otherwise_or_nowhere_are_told(tmp_path: Path) -> None:
    file = Gltf()
    material = picture(file)
    material["occlusionTexture"] = {"index": 0, "texCoord": 1}
    file.header["materials"] = [material]
    uv = file.add(2 * (BOX.vertices[:, :2] > 0))
    file.header["samplers"] = [{"wrapS": 33071}]
    file.header["textures"][0]["sampler"] = 0
    (mesh,), lost = read(file.show(file.box(TEXCOORD_0=uv, TEXCOORD_1=uv) | {"material": 0}), tmp_path)
    assert mesh.visual.material.occlusionTexture is None
    assert lost == [
        "a.gltf is shown without its occlusionTexture, which lies otherwise than its first picture",
        "a.gltf is shown with its picture repeated, which its file mirrors or does not repeat",
    ]
    (mesh,), lost = read(file.show(file.box() | {"material": 0}), tmp_path)
    assert not has_texture(mesh)
    assert "without its baseColorTexture: it has no TEXCOORD_0" in lost[0]


def test_one_colour_of_all_corners_is_a_material(tmp_path: Path) -> None:
    file = Gltf(materials=[{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 1, 0]}}])
    colours = file.add([[128, 64, 0, 255]] * 8, "uint8", normalized=True)
    (mesh,), lost = read(file.show(file.box(COLOR_0=colours)), tmp_path)
    assert mesh.visual.material.baseColorFactor.tolist() == [128, 64, 0, 255]
    (mesh,), lost = read(file.show(file.box(COLOR_0=colours) | {"material": 0}), tmp_path)
    assert mesh.visual.material.baseColorFactor.tolist() == [128, 32, 0, 255], "opaque, as it says"
    assert not lost


def test_colours_of_corners_reach_the_picture_that_renderers_show(tmp_path: Path) -> None:
    coloured = trimesh.creation.box(SIZE)
    coloured.unmerge_vertices()
    coloured.visual.face_colors = [(200, 100, 50, 255)] * 6 + [(20, 100, 50, 255)] * 6
    coloured.export(tmp_path / "table.glb")
    meshes, _ = load_meshes(tmp_path / "table.glb", tmp_path)
    write_glb(tmp_path / "written.glb", meshes)
    (mesh,), lost = load_meshes(tmp_path / "written.glb", tmp_path)
    picture = texture_of(mesh)
    assert picture is not None and not lost
    shown = {tuple(shade) for shade in np.asarray(picture).reshape(-1, 4)[:, :3].tolist()}
    linear = (np.array([[200, 100, 50], [20, 100, 50]]) / 255) ** (1 / 2.2)
    assert shown == {tuple(shade) for shade in (255 * linear).round().astype(int).tolist()}
    assert np.abs(np.asarray(mesh.vertex_normals)).max(axis=1) == pytest.approx(1.0), "every face is flat"


def test_what_a_file_needs_and_is_not_read_is_refused_by_name(tmp_path: Path) -> None:
    file = Gltf(extensionsRequired=["ACME_folded_meshes", "KHR_mesh_quantization", "KHR_materials_clearcoat"])
    with refused("E-MESH-EXTENSION", "needs ACME_folded_meshes, not read here", "export it without"):
        read(file.show(file.box()), tmp_path)


def test_what_is_not_read_is_told_in_a_line(tmp_path: Path) -> None:
    file = Gltf(extensionsUsed=["KHR_materials_transmission", "KHR_texture_transform"], animations=[{}], cameras=[{}])
    line = {"attributes": {"POSITION": file.add(CORNERS)}, "mode": 1}
    file.show(file.box(), line, camera=0)
    file.header["scenes"].append({"nodes": []})
    meshes, lost = read(file, tmp_path)
    assert len(meshes) == 1, "a mesh that a camera is fixed to is a mesh"
    others = "1 of its 2 scenes, animations, cameras, points or lines, KHR_materials_transmission"
    assert lost == [f"a.gltf has what is not read: {others}"]


def test_hidden_nodes_stay_hidden_and_files_without_scenes_are_shown_whole(tmp_path: Path) -> None:
    file = Gltf()
    file.show(file.box())
    file.header["nodes"] += [{"mesh": 0, "translation": [1, 0, 0], "children": [2]}, {"mesh": 0}]
    file.header["nodes"][0]["extensions"] = {"KHR_node_visibility": {"visible": False}}
    del file.header["scenes"], file.header["scene"]
    meshes, _ = read(file, tmp_path)
    assert [mesh.bounds.mean(axis=0)[0] for mesh in meshes] == pytest.approx([1, 1])


def test_a_picture_of_another_kind_is_told_unless_there_is_another(tmp_path: Path) -> None:
    file = Gltf(extensionsUsed=["KHR_texture_basisu"])
    uv = file.add(BOX.vertices[:, :2] > 0)
    file.header["materials"] = [picture(file)]
    file.header["images"].append({"bufferView": file.view(b"\xabKTX 20\xbb\r\n\x1a\n"), "mimeType": "image/ktx2"})
    file.header["textures"][0]["extensions"] = {"KHR_texture_basisu": {"source": 1}}
    file.show(file.box(TEXCOORD_0=uv) | {"material": 0})
    (mesh,), lost = read(file, tmp_path)
    assert has_texture(mesh)
    assert lost == ["a.gltf has what is not read: KHR_texture_basisu"]
    del file.header["textures"][0]["source"]
    (mesh,), lost = read(file, tmp_path)
    assert not has_texture(mesh)
    assert "without its picture 1, which is KTX2, not read here (export it as PNG or JPEG)" in lost[0]


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [("count", 9, "reads beyond its buffer"), ("byteOffset", -4, "reads beyond"), ("bufferView", 99, "index")],
)
def test_numbers_that_are_not_there_are_one_line(tmp_path: Path, key: str, value: int, says: str) -> None:
    file = Gltf()
    primitive = file.box()
    file.header["accessors"][primitive["attributes"]["POSITION"]][key] = value
    with refused("E-MESH-BROKEN", says):
        read(file.show(primitive), tmp_path)
    primitive = file.box()
    primitive["indices"] = file.add([0, 1, 99], "uint8")
    with refused("E-MESH-BROKEN", "a face names corner 99 of 8"):
        read(file.show(primitive), tmp_path)


def test_buffers_that_are_missing_and_old_files_are_one_line(tmp_path: Path) -> None:
    file = Gltf()
    path = file.show(file.box()).write(tmp_path / "a.gltf")
    text = json.loads(path.read_text())
    text["buffers"][0]["uri"] = "../a.bin"
    path.write_text(json.dumps(text))
    (tmp_path.parent / "a.bin").write_bytes(file.data)
    with refused("E-MESH-BROKEN", f"its buffer '../a.bin' is not in {tmp_path.name}/"):
        load_meshes(path, tmp_path)
    path.write_text(json.dumps(text | {"asset": {"version": "1.0"}}))
    with refused("E-MESH-BROKEN", "it is glTF 1.0, and 2.0 is read"):
        load_meshes(path, tmp_path)


def test_compressed_meshes_are_left_to_trimesh_with_their_material(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "DracoPy", ModuleType("DracoPy"))
    monkeypatch.setattr(sys.modules["DracoPy"], "__spec__", ModuleSpec("DracoPy", None), raising=False)
    draco, told = "KHR_draco_mesh_compression", {}

    def decoded(context: dict[str, Any]) -> None:
        told.update(context["data"])
        context["accessors"][context["primitive"]["attributes"]["POSITION"]] = BOX.vertices
        context["accessors"][context["primitive"]["indices"]] = BOX.faces

    monkeypatch.setitem(extensions._handlers["primitive_preprocess"], draco, decoded)
    file = Gltf(extensionsRequired=[draco], materials=[{}, {"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}])
    primitive = file.box(COLOR_0=file.add([[1, 1, 1]] * 8)) | {"material": 1}
    primitive["extensions"] = {draco: {"bufferView": file.view(b"packed"), "attributes": {"POSITION": 0}}}
    for accessor in file.header["accessors"]:
        accessor.pop("bufferView")
    (mesh,), lost = read(file.show(primitive), tmp_path)
    assert mesh.extents == pytest.approx(SIZE)
    assert mesh.visual.material.baseColorFactor.tolist() == [255, 0, 0, 255]
    assert told["attributes"] == {"POSITION": 0} and not lost
    primitive["targets"] = [{"POSITION": 0}]
    with refused("E-MESH-BROKEN", "and compressed", "export it uncompressed"):
        read(file, tmp_path)


def test_mirrored_nodes_keep_their_outside_outside(tmp_path: Path) -> None:
    file = Gltf()
    (mesh,) = read(file.show(file.box(), scale=[-1, 1, 1]), tmp_path)[0]
    assert mesh.volume > 0


def test_numbers_of_one_buffer_may_take_turns(tmp_path: Path) -> None:
    """Place and direction of a corner lie side by side, as most programs write them."""
    file = Gltf()
    primitive = file.box()
    rows = np.hstack([BOX.vertices, BOX.vertex_normals]).astype("<f4")
    both = file.view(rows.tobytes())
    file.header["bufferViews"][both]["byteStride"] = rows.strides[0]
    about = {"bufferView": both, "componentType": 5126, "count": len(rows), "type": "VEC3"}
    first = len(file.header["accessors"])
    file.header["accessors"] += [about, about | {"byteOffset": 12}]
    primitive["attributes"] = {"POSITION": first, "NORMAL": first + 1}
    (mesh,) = read(file.show(primitive), tmp_path)[0]
    assert mesh.bounds == pytest.approx(np.array([np.array(SIZE) / -2, np.array(SIZE) / 2]))
    assert mesh.vertex_normals == pytest.approx(BOX.vertex_normals, abs=1e-6)


def test_skins_are_bound_where_their_joints_were(tmp_path: Path) -> None:
    """A bone that lay along x at (2, 0, 0) when it was bound stands at (1, 2, 3) and points along y."""
    file = Gltf()
    joints, weights = file.add([[0, 0, 0, 0]] * 8, "uint8"), file.add([[1, 0, 0, 0]] * 8)
    bound = np.eye(4)
    bound[0, 3] = -2.0
    primitive = file.box(JOINTS_0=joints, WEIGHTS_0=weights)
    primitive["attributes"]["POSITION"] = file.add(np.add(BOX.vertices, [2.5, 0, 0]))
    file.show(primitive, skin=0)
    file.header["nodes"].append({"rotation": [0, 0, np.sqrt(0.5), np.sqrt(0.5)], "translation": [1, 2, 3]})
    file.header["skins"] = [{"joints": [1], "inverseBindMatrices": file.add([bound.T.ravel()])}]
    file.header["scenes"][0]["nodes"].append(1)
    (mesh,) = read(file, tmp_path)[0]
    assert mesh.extents == pytest.approx((0.4, 0.2, 0.6))
    assert mesh.bounds.mean(axis=0) == pytest.approx((1, 2.5, 3))


def test_every_face_is_painted_in_its_own_colour(tmp_path: Path) -> None:
    box = trimesh.creation.box(SIZE)
    shades = np.column_stack([20 * np.arange(12), 255 - 20 * np.arange(12), np.full(12, 7), np.full(12, 255)])
    box.visual.face_colors = shades.astype(np.uint8)
    write_glb(tmp_path / "a.glb", [box])
    (mesh,), _ = load_meshes(tmp_path / "a.glb", tmp_path)
    middles = np.asarray(mesh.visual.uv)[mesh.faces].mean(axis=1)
    shown = trimesh.visual.color.uv_to_color(middles, texture_of(mesh))
    which = np.linalg.norm(mesh.triangles_center[:, None] - box.triangles_center[None], axis=2).argmin(axis=1)
    np.testing.assert_array_equal(shown, shades[which])
    assert sorted(which) == list(range(12))
