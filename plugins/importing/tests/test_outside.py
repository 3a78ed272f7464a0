"""Models that name files of other folders, by every element that names files: nothing opens them."""

import re
from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.importing import mjcf_file
from roomkin.plugins.importing.importers.mjcf import read_mjcf
from roomkin.plugins.importing.imports import IMPORTERS, by_suffix, import_models, named_models
from roomkin.stages.articulated.mesh_reader import load_meshes
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.contracts.errors import InputError
from tests.opened import unopened
from tests.refusals import refused

BOX = '<geom type="box" size=".1 .1 .1"/>'
SPELLINGS = (
    "{secret}",
    "../outside/{name}",
    "parts/../../outside/{name}",
    "..\\outside\\{name}",
    "..%2foutside%2f{name}",
    "file://{secret}",
    "link{end}",
    "linked/{name}",
    "parts/linked/{name}",
)


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """A folder beside one with a good file of every kind, with links to it."""
    outside, folder = tmp_path / "outside", tmp_path / "mine"
    (folder / "parts").mkdir(parents=True)
    outside.mkdir()
    box = trimesh.creation.box((0.3, 0.2, 0.1))
    for end in ("stl", "obj", "glb", "ply", "dae"):
        box.export(outside / f"secret.{end}")
    (outside / "secret.xml").write_text(f'<mujoco><worldbody><body name="b">{BOX}</body></worldbody></mujoco>')
    (outside / "secret.mtl").write_text("newmtl m\nKd 1 0 0\n")
    (outside / "secret.bin").write_bytes(bytes(400))
    Image.new("RGB", (4, 4), "red").save(outside / "secret.png")
    for file in outside.iterdir():
        (folder / f"link{file.suffix}").symlink_to(file)
    (folder / "linked").symlink_to(outside)
    (folder / "parts/linked").symlink_to("../../outside")
    return folder


def spelt(folder: Path, end: str) -> Iterator[str]:
    secret = folder.parent / f"outside/secret{end}"
    return (spelling.format(secret=secret, name=secret.name, end=end) for spelling in SPELLINGS)


def schema() -> Iterator[tuple[tuple[str, ...], list[str]]]:
    """Every element of MJCF, by the elements that it lies in, and its attributes."""
    path: list[str] = []
    attributes: list[str] = []
    for line in mujoco.mj_printSchema(False, False).splitlines():
        if found := re.match(r"( *)([\w()]+) \(.\)\s*(.*)", line):
            if path:
                yield tuple(path), attributes
            path = [*path[: len(found[1]) // 3], found[2].replace("(world)body", "worldbody")]
            attributes = found[3].split()
        else:
            attributes += line.split()
    yield tuple(path), attributes


NAMING = [(path, name) for path, names in schema() for name in names if name.startswith("file")]
NAMING += [(("mujoco", "include"), "file"), (("mujoco", "worldbody", "body", "include"), "file")]


def test_mjcf_names_files_and_folders_by_no_other_attributes() -> None:
    names = {name for _, attributes in schema() for name in attributes if re.search("file|path|dir|ur[il]|src", name)}
    assert {name for name in names if not name.startswith("file")} == {
        *mjcf_file.DIRECTORIES, "strippath", "dir", "directional"  # of a light
    }  # fmt: skip
    assert {"mesh", "hfield", "skin", "texture", "model", "flexcomp", "include"} <= {path[-1] for path, _ in NAMING}


@pytest.mark.parametrize("seeing", [True, False], ids=["checked", "by MuJoCo alone"])
@pytest.mark.parametrize(("path", "name"), NAMING, ids=lambda part: part if isinstance(part, str) else "/".join(part))
def test_no_element_of_mjcf_reads_a_file_outside(
    mine: Path, path: tuple[str, ...], name: str, seeing: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not seeing:  # as if the attribute were one that we do not know
        monkeypatch.setattr(mjcf_file, "_names", lambda element: [])
    ends = {"texture": (".png",), "hfield": (".png",), "model": (".xml",), "include": (".xml",)}
    more = {"flexcomp": 'name="n" type="mesh" ', "include": ""}.get(path[-1], 'name="n" ')
    said = list[str]()
    for file in (file for end in ends.get(path[-1], (".stl", ".obj")) for file in spelt(mine, end)):
        text = f'<{path[-1]} {more}{name}="{file}"/>'
        for above in reversed(path[:-1]):
            text = f"<{above}>{text}</{above}>"
        (mine / "m.xml").write_text(text.replace("</mujoco>", f"<worldbody>{BOX}</worldbody></mujoco>"))
        with unopened(mine.parent / "outside"):
            try:
                read_mjcf(mine / "m.xml", mine)
                said.append("nothing")
            except InputError as error:
                said.append(error.code)
    assert set(said) <= ({"E-FILE-OUTSIDE", "E-FILE-MISSING"} if seeing else {"E-MJCF-REFUSED", "nothing"})


ATTACHING = (
    '<mujoco><asset><model name="s" file="{file}"/></asset><worldbody><body name="b">'
    f'{BOX}<attach model="s" body="b" prefix="p_"/></body></worldbody></mujoco>'
)
MESH = '<asset><mesh name="m" file="secret.stl"/></asset><worldbody><body name="b"><geom type="mesh" mesh="m"/></body>'


@pytest.mark.parametrize("key", mjcf_file.DIRECTORIES)
@pytest.mark.parametrize("folder", ["../outside", "{outside}", "linked", "..\\outside", "parts/../../outside/"])
def test_no_folder_of_a_model_that_is_attached_or_included_lies_outside(mine: Path, key: str, folder: str) -> None:
    told = folder.format(outside=mine.parent / "outside")
    (mine / "m.xml").write_text(ATTACHING.format(file="one.xml"))
    (mine / "one.xml").write_text(ATTACHING.format(file="parts/two.xml"))
    (mine / "parts/two.xml").write_text('<mujoco><include file="three.xml"/></mujoco>')
    three = f'<mujoco><compiler {key}="{told}"/>{MESH}</worldbody></mujoco>'
    (mine / "parts/three.xml").write_text(three)
    with unopened(mine.parent / "outside"), refused("E-FILE-OUTSIDE", "'secret.stl', outside of mine/"):
        read_mjcf(mine / "m.xml", mine)


def test_models_that_are_attached_are_read_from_the_folder(mine: Path) -> None:
    (mine / "m.xml").write_text(ATTACHING.format(file="parts/one.xml"))
    (mine / "parts/one.xml").write_text(f'<mujoco><compiler meshdir="meshes"/>{MESH}</worldbody></mujoco>')
    (mine / "parts/meshes").mkdir()
    trimesh.creation.box((0.3, 0.2, 0.1)).export(mine / "parts/meshes/secret.stl")
    robot = read_mjcf(mine / "m.xml", mine)
    assert robot.links["p_b"].visuals[0].mesh.extents == pytest.approx((0.3, 0.2, 0.1))


def test_textures_that_a_viewer_would_open_are_read(mine: Path) -> None:
    Image.new("RGB", (8, 8), "red").save(mine / "t.png")
    for how, embed in (('<compiler passthrough="textures"/>', ""), ("", ' embed="false"')):
        texture = f'<texture name="t" type="2d" file="t.png"{embed}/>'
        looks = f'<asset>{texture}<material name="m" texture="t"/></asset>'
        shown = BOX.replace("/>", ' material="m"/>')
        (mine / "m.xml").write_text(f"<mujoco>{how}{looks}<worldbody>{shown}</worldbody></mujoco>")
        assert read_mjcf(mine / "m.xml", mine).links["world"].visuals[0].color == (1, 0, 0, 1)


MESHES = {
    "a.obj": (".mtl", "mtllib {file}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"),
    "b.obj": (".png", "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"),
    "c.gltf": (".bin", '{"asset":{"version":"2.0"},"buffers":[{"uri":"FILE","byteLength":400}],"bufferViews":'
               '[{"buffer":0,"byteLength":36},{"buffer":0,"byteLength":12}],"accessors":[{"bufferView":0,'
               '"componentType":5126,"count":3,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":'
               '{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0,'
               '"images":[{"uri":"FILE"}]}'),
    "d.ply": (".png", "ply\nformat ascii 1.0\ncomment TextureFile {file}\nelement vertex 3\nproperty float x\n"
              "property float y\nproperty float z\nproperty float u\nproperty float v\nelement face 1\n"
              "property list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 0 0\n0 1 0 0 0\n3 0 1 2\n"),
    "e.dae": (".png", ""),
}  # fmt: skip


@pytest.mark.parametrize("name", MESHES)
def test_no_mesh_reads_a_file_outside(mine: Path, name: str) -> None:
    end, text = MESHES[name]
    if name == "e.dae":
        box = trimesh.creation.box()
        box.visual = trimesh.visual.TextureVisuals(uv=box.vertices[:, :2], image=Image.new("RGB", (2, 2)))
        box.export(mine / "made.dae")
        text = re.sub("<init_from>[^<]*</init_from>", "<init_from>FILE</init_from>", (mine / "made.dae").read_text())
        text = text if "FILE" in text else text.replace("<library_effects", IMAGES + "<library_effects", 1)
    for file in spelt(mine, end):
        (mine / "b.mtl").write_text(
            "".join(f"{key} {file}\n" for key in ("newmtl m\nmap_Kd", "map_Ks", "bump", "map_d"))
        )
        (mine / name).write_text(text.replace("{file}", file).replace("FILE", file.replace("\\", "\\\\")))
        with unopened(mine.parent / "outside"):
            try:
                load_meshes(mine / name, mine)
            except InputError as error:
                assert error.code == "E-MESH-BROKEN"


IMAGES = '<library_images><image id="i"><init_from>FILE</init_from></image></library_images>'


@pytest.mark.parametrize("end", [".stl", ".obj", ".glb", ".ply", ".dae"])
def test_no_link_of_a_urdf_reads_a_mesh_outside(mine: Path, end: str) -> None:
    for file in [*spelt(mine, end), f"package://../outside/secret{end}", f"$(find x)/../outside/secret{end}"]:
        mesh = f'<geometry><mesh filename="{file}"/></geometry>'
        extra = f'<mujoco><compiler meshdir="../outside"/></mujoco><material name="m"><texture filename="{file}"/>'
        link = f'<link name="a"><visual>{mesh}</visual><collision>{mesh}</collision></link>'
        (mine / "m.urdf").write_text(f'<robot name="r">{extra}</material>{link}</robot>')
        code = "E-FILE-OUTSIDE" if file.startswith(("link", "parts/linked")) else "E-FILE-MISSING"
        with unopened(mine.parent / "outside"), refused(code):
            read_urdf(mine / "m.urdf", mine)


def test_links_in_a_folder_of_models_lead_nowhere(mine: Path, tmp_path: Path) -> None:
    """Neither looking for models nor importing them, nor their notes."""
    trimesh.creation.box((0.3, 0.2, 0.25)).export(mine / "zz.obj")
    (mine / "parts/asset.json").symlink_to(tmp_path / "outside/secret.json")
    (tmp_path / "outside/secret.json").write_text("{}")
    trimesh.creation.box((0.3, 0.2, 0.25)).export(mine / "parts/box.obj")
    (mine / "meta.json").symlink_to(tmp_path / "outside/secret.json")
    (mine / "model").symlink_to(".")
    (mine / "obj").symlink_to(".")
    kinds = by_suffix(IMPORTERS)
    with unopened(tmp_path / "outside"):
        assets, left_out = import_models(named_models([mine], kinds), kinds, tmp_path / "out")
    assert [asset.id for asset in assets] == ["zz_zz"], left_out
    assert all("link out of mine/" in line for line in left_out) and len(left_out) > 4


def test_no_picture_runs_a_program(mine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = mine / "gs"
    script.write_text(f"#!/bin/sh\ntouch {mine}/ran\n")
    script.chmod(0o755)
    monkeypatch.setenv("PATH", str(mine), prepend=":")
    (mine / "t.png").write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 4 4\n%%EndComments\nshowpage\n%%EOF\n")
    (mine / "b.mtl").write_text("newmtl m\nmap_Kd t.png\n")
    (mine / "b.obj").write_text(MESHES["b.obj"][1])
    _, lost = load_meshes(mine / "b.obj", mine)
    assert lost == [
        "b.obj is shown without 't.png', which is no whole picture (damaged, cut off, or of another format)"
    ]
    assert not (mine / "ran").exists()
