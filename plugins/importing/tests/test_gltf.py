"""glTF: looks as the file says them; what is not read is refused or told by name."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.importing.mesh_files import gltf_file
from roomkin.plugins.importing.tests.gltf_files import BOX, Gltf
from roomkin.stages.articulated.mesh_reader import has_texture, load_meshes, texture_of
from roomkin.stages.articulated.mesh_writer import write_glb
from roomkin.stages.contracts.errors import InputError
from tests.refusals import refused

SIZE = (0.2, 0.4, 0.6)


def read(file: Gltf, folder: Path) -> tuple[list[Any], list[str]]:
    return load_meshes(file.write(folder / "a.gltf"), folder)


def test_more_meshes_or_nodes_than_are_shown_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = Gltf()
    file.show(file.box(), file.box())
    monkeypatch.setattr(gltf_file, "MOST_SHAPES", 2)
    assert len(read(file, tmp_path)[0]) == 2
    monkeypatch.setattr(gltf_file, "MOST_SHAPES", 1)
    with pytest.raises(InputError, match="more than 1 meshes"):
        read(file, tmp_path)
    monkeypatch.setattr(gltf_file, "MOST_SHAPES", 0)
    with refused("E-MODEL-PARTS", "has 1 nodes"):
        read(file, tmp_path)


UNREAD: dict[str, dict[str, Any]] = {  # what is put into a file: into its node, its primitive, its first accessor
    "quantised numbers": {"accessor": {"componentType": 5122}},
    "instances": {"node": {"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {}}}}},
    "skins": {"node": {"skin": 0}},
    "morph targets": {"primitive": {"targets": [{"POSITION": 0}]}},
    "triangle fans": {"primitive": {"mode": 6}},
    "sparse accessors": {"accessor": {"sparse": {"count": 1}}},
    "hidden nodes": {"node": {"extensions": {"KHR_node_visibility": {"visible": False}}}},
    "compressed numbers": {"accessor": {"bufferView": None}},
}


@pytest.mark.parametrize("name", UNREAD)
def test_what_changes_a_shape_and_is_not_read_is_refused_by_name(tmp_path: Path, name: str) -> None:
    file, put = Gltf(), UNREAD[name]
    file.show(file.box() | put.get("primitive", {}), **put.get("node", {}))
    accessor = file.header["accessors"][0] | put.get("accessor", {})
    file.header["accessors"][0] = {key: value for key, value in accessor.items() if value is not None}
    with refused("E-MESH-EXTENSION", f"has {name}, not read here", "re-export it with modifiers applied"):
        read(file, tmp_path)


@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "KHR_mesh_quantization", "ACME_folded_meshes"])
def test_an_extension_that_is_needed_and_not_read_is_refused_by_name(tmp_path: Path, name: str) -> None:
    file = Gltf(extensionsRequired=[name, "KHR_materials_clearcoat"])
    with refused("E-MESH-EXTENSION", f"has {name}, not read here"):
        read(file.show(file.box()), tmp_path)


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
        (
            {"extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.25]}}},
            (0, 0.25, 0, 0.5),  # scaled before it is turned
        ),
    ],
)
@pytest.mark.parametrize("kind", ["float32", "uint16"])
def test_pictures_lie_where_the_file_puts_them(
    tmp_path: Path, info: dict[str, Any], within: tuple[float, ...], kind: str
) -> None:
    file = Gltf(extensionsUsed=["KHR_texture_transform"])
    one = 65534 if kind == "uint16" else 1
    whole = (BOX.vertices[:, :2] > 0) * one
    sets = {f"TEXCOORD_{k}": file.add(whole / (1 + k), kind, normalized=one > 1) for k in (0, 1)}
    file.header["materials"] = [picture(file, **info)]
    (mesh,), lost = read(file.show(file.box(**sets) | {"material": 0}), tmp_path)
    u, v = mesh.visual.uv.T
    assert (u.min(), u.max(), v.min(), v.max()) == pytest.approx(within, abs=1e-4)
    assert texture_of(mesh) is not None
    assert not lost


def test_pictures_that_lie_otherwise_or_nowhere_are_told(tmp_path: Path) -> None:
    file = Gltf()
    material = picture(file)
    material["occlusionTexture"] = {"index": 0, "texCoord": 1}
    file.header["materials"] = [material]
    uv = file.add(BOX.vertices[:, :2] > 0)
    (mesh,), lost = read(file.show(file.box(TEXCOORD_0=uv, TEXCOORD_1=uv) | {"material": 0}), tmp_path)
    assert mesh.visual.material.occlusionTexture is None
    assert lost == ["a.gltf is shown without its occlusionTexture, which lies otherwise than its first picture"]
    (mesh,), lost = read(file.show(file.box() | {"material": 0}), tmp_path)
    assert not has_texture(mesh)
    assert "without a picture that it places nowhere" in lost[-1]


def test_a_picture_of_another_kind_is_told_unless_there_is_another(tmp_path: Path) -> None:
    file = Gltf(extensionsUsed=["KHR_texture_basisu"])
    file.header["materials"] = [picture(file)]
    file.header["images"].append({"bufferView": file.view(b"\xabKTX 20\xbb\r\n\x1a\n"), "mimeType": "image/ktx2"})
    file.header["textures"][0]["extensions"] = {"KHR_texture_basisu": {"source": 1}}
    file.show(file.box(TEXCOORD_0=file.add(BOX.vertices[:, :2] > 0)) | {"material": 0})
    (mesh,), lost = read(file, tmp_path)
    assert has_texture(mesh)
    assert lost == ["a.gltf has what is not read: KHR_texture_basisu"]
    del file.header["textures"][0]["source"]
    (mesh,), lost = read(file, tmp_path)
    assert not has_texture(mesh)
    assert "without its baseColorTexture, which is no picture that is read here (export it as PNG" in lost[0]


def test_one_color_of_all_corners_is_a_material(tmp_path: Path) -> None:
    file = Gltf(materials=[{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 1, 0]}}, picture(Gltf())])
    colors = file.add([[128, 64, 0, 255]] * 8, "uint8", normalized=True)
    (mesh,), lost = read(file.show(file.box(COLOR_0=colors)), tmp_path)
    assert mesh.visual.material.baseColorFactor.tolist() == [128, 64, 0, 255]
    (mesh,), lost = read(file.show(file.box(COLOR_0=colors) | {"material": 0}), tmp_path)
    assert mesh.visual.material.baseColorFactor.tolist() == [128, 32, 0, 255], "opaque, as it says"
    assert not lost


def test_colors_of_corners_are_told_where_a_picture_is(tmp_path: Path) -> None:
    file = Gltf()
    file.header["materials"] = [picture(file)]
    corners = {"COLOR_0": file.add(BOX.vertices > 0), "TEXCOORD_0": file.add(BOX.vertices[:, :2] > 0)}
    (mesh,), lost = read(file.show(file.box(**corners) | {"material": 0}), tmp_path)
    assert has_texture(mesh)
    assert lost == ["a.gltf is shown without the colors of its corners, which would tint its picture"]


def test_colors_of_corners_reach_the_picture_that_renderers_show(tmp_path: Path) -> None:
    colored = trimesh.creation.box(SIZE)
    colored.unmerge_vertices()
    colored.visual.face_colors = [(200, 100, 50, 255)] * 6 + [(20, 100, 50, 255)] * 6
    colored.export(tmp_path / "table.glb")
    meshes, _ = load_meshes(tmp_path / "table.glb", tmp_path)
    write_glb(tmp_path / "written.glb", meshes)
    (mesh,), lost = load_meshes(tmp_path / "written.glb", tmp_path)
    picture = texture_of(mesh)
    assert picture is not None and not lost
    shown = {tuple(shade) for shade in np.asarray(picture).reshape(-1, 4)[:, :3].tolist()}
    linear = (np.array([[200, 100, 50], [20, 100, 50]]) / 255) ** (1 / 2.2)
    assert shown == {tuple(shade) for shade in (255 * linear).round().astype(int).tolist()}
    assert np.abs(np.asarray(mesh.vertex_normals)).max(axis=1) == pytest.approx(1.0), "every face is flat"


def test_every_face_is_painted_in_its_own_color(tmp_path: Path) -> None:
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


def test_what_is_not_read_is_told_in_a_line(tmp_path: Path) -> None:
    file = Gltf(extensionsUsed=["KHR_materials_transmission", "KHR_texture_transform"], animations=[{}], cameras=[{}])
    line = {"attributes": {"POSITION": file.add(BOX.vertices)}, "mode": 1}
    file.show(file.box(), line, camera=0)
    file.header["scenes"].append({"nodes": []})
    meshes, lost = read(file, tmp_path)
    assert len(meshes) == 1, "a mesh that a camera is fixed to is a mesh"
    others = "1 of its 2 scenes, animations, cameras, points or lines, KHR_materials_transmission"
    assert lost == [f"a.gltf has what is not read: {others}"]


def test_files_without_scenes_are_shown_whole(tmp_path: Path) -> None:
    file = Gltf()
    file.show(file.box())
    file.header["nodes"] += [{"translation": [1, 0, 0], "children": [2]}, {"mesh": 0}]
    del file.header["scenes"], file.header["scene"]
    meshes, _ = read(file, tmp_path)
    assert sorted(mesh.bounds.mean(axis=0)[0] for mesh in meshes) == pytest.approx([0, 1])


@pytest.mark.parametrize(
    ("part", "key", "value"),
    [
        ("accessors", "count", 9),
        ("accessors", "count", 2**31),
        ("accessors", "count", -1),
        ("accessors", "count", 2.5),
        ("accessors", "byteOffset", -4),
        ("accessors", "byteOffset", 4),
        ("accessors", "type", "VEC9"),
        ("accessors", "componentType", 1),
        ("accessors", "bufferView", 99),
        ("bufferViews", "byteStride", 16),
        ("bufferViews", "byteLength", 2**40),
    ],
)
def test_numbers_that_are_not_there_are_one_line(tmp_path: Path, part: str, key: str, value: float | str) -> None:
    file = Gltf()
    file.show(file.box()).header[part][0][key] = value
    with refused("E-MESH-BROKEN", "cannot be read as a mesh"):
        read(file, tmp_path)


def test_faces_without_corners_missing_buffers_and_old_files_are_one_line(tmp_path: Path) -> None:
    file = Gltf()
    with refused("E-MESH-BROKEN", "a face names corner 99 of 8"):
        read(file.show(file.box() | {"indices": file.add([0, 1, 99], "uint8")}), tmp_path)
    path = file.show(file.box()).write(tmp_path / "a.gltf")
    text = json.loads(path.read_text())
    text["buffers"][0]["uri"] = "../a.bin"
    path.write_text(json.dumps(text))
    (tmp_path.parent / "a.bin").write_bytes(file.data)
    with refused("E-MESH-BROKEN", f"its file '../a.bin' is not in {tmp_path.name}/"):
        load_meshes(path, tmp_path)
    text["buffers"][0]["uri"] = "linked.bin"
    path.write_text(json.dumps(text))
    (tmp_path / "linked.bin").symlink_to(tmp_path.parent / "a.bin")
    with refused("E-MESH-BROKEN", f"its file 'linked.bin' is a link out of {tmp_path.name}/"):
        load_meshes(path, tmp_path)
    path.write_text(json.dumps(text | {"asset": {"version": "1.0"}}))
    with refused("E-MESH-BROKEN", "only GLTF 2 is supported"):
        load_meshes(path, tmp_path)


def break_mesh(header: dict[str, Any]) -> None:
    header["nodes"][0]["mesh"] = -1


def break_child(header: dict[str, Any]) -> None:
    header["nodes"][0]["children"] = [-1]


def break_indices(header: dict[str, Any]) -> None:
    header["meshes"][0]["primitives"][0]["indices"] = 99


def break_position(header: dict[str, Any]) -> None:
    header["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = -1


def give_two_parents(header: dict[str, Any]) -> None:
    header["nodes"] += [{"children": [0]}]
    header["scenes"][0]["nodes"] = [0, 1]


def ask_for_newer(header: dict[str, Any]) -> None:
    header["asset"]["minVersion"] = "9.0"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (break_mesh, "its mesh is -1"),
        (break_child, "its children is -1"),
        (break_indices, "list index out of range"),
        (break_position, "its POSITION is -1"),
        (give_two_parents, "its node 0 has two parents"),
        (ask_for_newer, "has a version after 2.0, not read here"),
    ],
)
def test_numbers_that_name_nothing_are_refused(tmp_path: Path, change: Any, words: str) -> None:
    file = Gltf()
    file.show(file.box())
    change(file.header)
    with pytest.raises(InputError, match=words):
        read(file, tmp_path)
