"""Parts of a model that is not read are no models; a folder of plain meshes keeps all of them."""

from pathlib import Path

import pytest
import trimesh

from roomkin.plugins.importing.discover import discover
from roomkin.plugins.importing.import_ import run
from tests.refusals import refused

KINDS = [".urdf", ".glb", ".obj"]
XACRO = '<robot xmlns:xacro="x"><xacro:macro name="m"><mesh filename="meshes/${n}.obj"/></xacro:macro></robot>'


def write(folder: Path, files: tuple[str, ...]) -> Path:
    """A user's folder of such files."""
    for name in files:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix in (".obj", ".glb"):
            trimesh.creation.box((0.5, 0.5, 0.9)).export(path)
        else:
            path.write_text(XACRO)
    return folder


def models(folder: Path) -> set[str]:
    return {one.path.relative_to(folder).as_posix() for one in discover(folder, KINDS)}


WHOLES = [
    "a.urdf.xacro",
    "a.xacro",
    "a.usd",
    "a.usda",
    "a.usdc",
    "a.usdz",
    "a.fbx",
    "a.blend",
    "a.sdf",
    "a.skp",
    "a.3ds",
    "a.max",
    "a.step",
]


@pytest.mark.parametrize("whole", WHOLES)
@pytest.mark.parametrize(
    "part",
    [
        "cabinet/meshes/top.obj",
        "cabinet/meshes/visual/table.obj",
        "cabinet/parts/seat.glb",
        "cabinet/visual/base_link.obj",
        "cabinet/Collision/1.obj",
        "cabinet/a_collision.obj",
        "cabinet/UCX_a_01.obj",
        "cabinet/door.obj",
        "cabinet/left_drawer_2.obj",
        "cabinet/body.glb",
    ],
)
def test_parts_of_what_is_not_read(tmp_path: Path, whole: str, part: str, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write(tmp_path, (f"cabinet/{whole}", part, "chair/b.obj"))
    assert models(folder) == {"chair/b.obj"}
    assert f"1 file beside cabinet/{whole}, taken for parts of it: no models" in capsys.readouterr().err
    (folder / f"cabinet/{whole}").unlink()
    assert models(folder) == {part, "chair/b.obj"}, "alone it is a model"


@pytest.mark.parametrize("whole", WHOLES)
def test_what_lies_elsewhere_or_is_called_otherwise_stays(tmp_path: Path, whole: str) -> None:
    kept = ("sofa/b.obj", "sofa/red/sofa.glb", "chair/meshes/c.obj", "chair/body.obj")
    assert models(write(tmp_path, (f"sofa/{whole}", *kept))) == {*kept}


def test_a_package_has_its_model_and_its_meshes_side_by_side(tmp_path: Path) -> None:
    package = ("kitchen_description/urdf/k.urdf.xacro", "kitchen_description/meshes/top.obj")
    assert models(write(tmp_path, (*package, "chair/a.obj"))) == {"chair/a.obj"}


def test_a_mesh_called_as_another_models_part_stays(tmp_path: Path) -> None:
    """Below its own model it is a part, and where that names its folder; elsewhere many things are called so."""
    urdf = '<robot name="a"><link name="l"><visual><geometry><mesh filename="package://far/base/model.obj"/></geometry></visual></link></robot>'
    write(
        tmp_path,
        ("chair/a/model.obj", "chair/b/model.obj", "table/c/urdf/c.urdf", "table/c/model.obj", "lib/base/model.obj"),
    )
    (tmp_path / "table/c/urdf/c.urdf").write_text(urdf)
    assert models(tmp_path) == {"chair/a/model.obj", "chair/b/model.obj", "table/c/urdf/c.urdf"}
    pack = write(tmp_path / "pack", ("urdf/c.urdf", "set/model.obj"))
    (pack / "urdf/c.urdf").write_text(urdf)
    assert models(pack) == {"urdf/c.urdf"}


def test_xacro_that_is_called_urdf(tmp_path: Path) -> None:
    assert models(write(tmp_path, ("cabinet/a.urdf", "cabinet/meshes/top.obj"))) == {"cabinet/a.urdf"}


def test_what_to_export_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write(tmp_path / "theirs", ("cabinet/a.urdf.xacro", "cabinet/meshes/top.obj"))
    with refused("E-MODELS-NONE", "only parts of models (top.obj", "1 .xacro", "xacro FILE > model.urdf"):
        run(folder, out=tmp_path / "mine")
    write(folder, ("sofa/s.fbx", "sofa/s_collision.obj", "chair/a.obj"))
    run(folder, out=tmp_path / "mine")
    said = capsys.readouterr()
    assert "not read (1 .fbx, 1 .xacro): export them as URDF, MJCF or GLB (xacro FILE > model.urdf)" in said.err
    assert "1 of 1 models can be used" in said.out
