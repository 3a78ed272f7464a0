"""Pictures that mesh files name: found inside the user's folder wherever they lie, and a line for each that is lost."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.importing.tests.own_models import import_folder
from roomkin.stages.articulated.mesh_reader import has_texture, load_meshes
from roomkin.stages.articulated.urdf_reader import read_urdf

QUAD = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACES = "usemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/1 5/2 4/3\n"


def picture(side: int = 8) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (side, side, 3), np.uint8)).save(buffer, "PNG")
    return buffer.getvalue()


def partnet(folder: Path, named: str, data: bytes = b"", inside: str = "images/x.png") -> Path:
    """<folder>/7/textured_objs/a.obj whose material names a picture."""
    (folder / "7/textured_objs").mkdir(parents=True)
    (folder / "7/textured_objs/a.mtl").write_text(f"newmtl skin\nKd 0.5 0.5 0.5\nmap_Kd {named}\n")
    (folder / "7/textured_objs/a.obj").write_text(f"mtllib a.mtl\n{QUAD}{FACES}")
    if data:
        (folder / "7" / inside).parent.mkdir(parents=True, exist_ok=True)
        (folder / "7" / inside).write_bytes(data)
    return folder / "7/textured_objs/a.obj"


@pytest.mark.parametrize(
    "named", ["../images/x.png", r"..\images\x.png", "-s 1 1 1 ../images/x.png", "../images/X.PNG", "../images/%78.png"]
)
def test_a_picture_in_another_folder_of_the_users_arrives(tmp_path: Path, named: str) -> None:
    meshes, lost = load_meshes(partnet(tmp_path, named, picture()), tmp_path)
    assert not lost
    assert [has_texture(mesh) for mesh in meshes] == [True]


@pytest.mark.parametrize(
    ("named", "data", "why"),
    [
        ("../images/y.png", picture(), r"'\.\./images/y\.png', which is not in theirs/"),
        ("../../../secret.png", picture(), r"'\.\./\.\./\.\./secret\.png', which is not in theirs/"),
        ("/etc/hostname", picture(), "which is not in theirs/"),
        ("../images/x.png", picture()[:-60], "which is no whole picture"),
        ("../images/x.png", b"no picture", "which is no whole picture"),
    ],
)
def test_a_picture_that_is_lost_is_said(tmp_path: Path, named: str, data: bytes, why: str) -> None:
    (tmp_path / "secret.png").write_bytes(picture())
    meshes, lost = load_meshes(partnet(tmp_path / "theirs", named, data), tmp_path / "theirs")
    assert [has_texture(mesh) for mesh in meshes] == [False]
    assert len(lost) == 1
    assert re.search(why, lost[0])


def test_a_picture_that_is_too_large_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 50)
    _, lost = load_meshes(partnet(tmp_path, "../images/x.png", picture()), tmp_path)
    assert lost == ["a.obj is shown without '../images/x.png', which is too large"]


def test_a_material_file_that_is_missing_is_said(tmp_path: Path) -> None:
    path = partnet(tmp_path, "x.png")
    path.with_suffix(".mtl").unlink()
    assert load_meshes(path, tmp_path)[1] == [f"a.obj is shown without 'a.mtl', which is not in {tmp_path.name}/"]


@pytest.mark.parametrize("cut", [0, 60, 100_000])
def test_a_picture_inside_a_glb_that_is_cut_short_is_said(tmp_path: Path, cut: int) -> None:
    mesh = trimesh.creation.box()
    mesh.visual = trimesh.visual.TextureVisuals(
        uv=np.zeros((8, 2)),
        material=trimesh.visual.material.PBRMaterial(baseColorTexture=Image.open(io.BytesIO(picture()))),
    )
    data = bytearray(mesh.export(file_type="glb"))
    start = data.index(b"\x89PNG")
    end = data.index(b"IEND") + 8
    data[max(start, end - cut) : end] = bytes(end - max(start, end - cut))
    (tmp_path / "a.glb").write_bytes(data)
    meshes, lost = load_meshes(tmp_path / "a.glb", tmp_path)
    assert [has_texture(one) for one in meshes] == [cut == 0]
    assert [line.startswith("a.glb is shown without its baseColorTexture, which is no") for line in lost] == [True] * (
        cut > 0
    )


def test_import_and_own_say_what_is_lost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    partnet(tmp_path / "theirs", "../images/gone.png")
    mesh = '<link name="a"><visual><geometry><mesh filename="textured_objs/a.obj"/></geometry></visual></link>'
    urdf = tmp_path / "theirs/7/mobility.urdf"
    urdf.write_text(f'<robot name="r">{mesh}</robot>')
    said = "a.obj is shown without '../images/gone.png', which is not in theirs/"
    assert read_urdf(urdf, tmp_path / "theirs").remarks == (said,)
    import_folder(tmp_path / "theirs", tmp_path / "library")
    assert said in capsys.readouterr().out


def test_corners_that_are_no_numbers_are_said(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 0 1\nv nan 0 1\nv 0 1 0\nf 1 2 3\nf 1 3 4\nf 1 3 5\n")
    meshes, lost = load_meshes(tmp_path / "a.obj", tmp_path)
    assert lost == ["a.obj: corners that are no numbers are left out"]
    assert sum(len(mesh.faces) for mesh in meshes) == 2
