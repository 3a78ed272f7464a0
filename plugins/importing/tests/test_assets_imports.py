"""Importing other people's models: known answers from small URDFs, and one clear line for each way to break one."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from roomkin.plugins.importing import imports
from roomkin.plugins.importing.discover import discover
from roomkin.plugins.importing.sandbox import snake_case
from roomkin.plugins.importing.tests.own_models import import_folder, import_model
from roomkin.stages.articulated.mesh_reader import convex_pieces
from roomkin.stages.articulated.model import RobotModel, link_frames, measure_closed_box
from roomkin.stages.articulated.resizing import resize_asset, stretch_model
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.library import Asset
from tests.refusals import refused
from tests.unit.articulated_models import CABINET, textured_box, write_cabinet, write_kitchen


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A user's folder with one cabinet."""
    write_cabinet(tmp_path / "mine")
    return tmp_path / "mine"


def test_urdf_is_imported_with_doors_drawers_and_handles(folder: Path, tmp_path: Path) -> None:
    (asset,) = import_folder(folder, tmp_path / "models")
    assert (asset.id, asset.category, asset.doors, asset.drawers) == ("bottom_cabinet_oak_1", "bottom_cabinet", 1, 1)
    hinge, slide = asset.joints
    assert (hinge.lower, hinge.upper, hinge.axis) == (0.0, 1.5, (0.0, 0.0, 1.0)), "turned round to close at 0"
    assert (hinge.handle, hinge.handle_link) == ("knob", "door_knob")
    assert (slide.upper, slide.handle_link) == (0.2, None), "nothing of it stands out"
    assert np.allclose(asset.box_min, (-0.2, -0.3, 0.0), atol=1e-6)
    assert np.allclose(asset.box_max, (0.25, 0.3, 0.925), atol=1e-4)
    assert asset.provenance == "imported: bottom_cabinet/Oak 1/cab.urdf"
    assert read_json(Asset, tmp_path / "models" / asset.id / "asset.json") == asset
    again = read_urdf(tmp_path / "models" / asset.id / "model.urdf", tmp_path / "models")
    assert np.allclose(measure_closed_box(again), [asset.box_min, asset.box_max], atol=2e-5)
    assert again.links["body"].mass == 12


def test_resized_import_has_exactly_the_size(folder: Path, tmp_path: Path) -> None:
    (asset,) = import_folder(folder, tmp_path / "models")
    out = resize_asset(tmp_path / "models" / asset.id, (0.9, 0.3, 1.85), tmp_path / "sized")
    larger = read_json(Asset, out / "asset.json")
    assert larger.size == pytest.approx((0.9, 0.3, 1.85), abs=1e-5)
    assert larger.joints[1].upper == pytest.approx(0.4, rel=1e-3), "the drawer slides along x, which doubled"
    assert larger.joints[0].upper == 1.5
    assert larger.mass == pytest.approx(asset.mass * 2 * 0.5 * 2, rel=0.01)
    assert resize_asset(tmp_path / "models" / asset.id, (0.9, 0.3, 1.85), tmp_path / "sized") == out
    assert (
        resize_asset(tmp_path / "models" / asset.id, asset.size, tmp_path / "sized") == tmp_path / "models" / asset.id
    )
    for extent in (-1, 0, float("nan"), float("inf"), 1e30):
        with refused("E-MODEL-SIZE"):
            resize_asset(tmp_path / "models" / asset.id, (0.9, extent, 1), tmp_path / "sized")
    assert [path.name for path in (tmp_path / "sized").iterdir()] == [out.name]


def test_stretching_a_turned_link_scales_along_the_assets_axes(folder: Path) -> None:
    robot = read_urdf(folder / "bottom_cabinet" / "Oak 1" / "cab.urdf", folder)
    before, after = measure_closed_box(robot), measure_closed_box(stretch_model(robot, (2.0, 3.0, 0.5)))
    assert np.allclose(after, before * [2.0, 3.0, 0.5], atol=1e-9)
    slid = [link_frames(r, 1.0)["tray"][:3, 3] for r in (robot, stretch_model(robot, (2.0, 3.0, 0.5)))]
    assert np.allclose(slid[1], slid[0] * [2.0, 3.0, 0.5], atol=1e-9)


def test_stretched_inertia_is_that_of_the_stretched_box() -> None:
    from roomkin.stages.articulated.model import Link, RobotModel, Visual

    box = trimesh.creation.box([0.2, 0.3, 0.4])
    link = Link("a", [Visual(box)], [box], 2.0, np.zeros(3), 2 / 12 * np.diag([0.25, 0.20, 0.13]))
    long = stretch_model(RobotModel("r", {"a": link}), (2.0, 1.0, 1.0)).links["a"]
    assert long.mass == pytest.approx(4.0)
    assert np.allclose(long.inertia, 4 / 12 * np.diag([0.25, 0.32, 0.25]))


def test_meshes_become_one_body_with_notes(tmp_path: Path) -> None:
    mine = tmp_path / "mine" / "Desk Lamp!"
    mine.mkdir(parents=True)
    trimesh.creation.box([0.1, 0.4, 0.2]).export(mine / "a.glb")  # glTF: y up, z forward
    (mine / "asset.json").write_text('{"mass": 3.0, "licence": "CC-BY-4.0", "placement": "object", "scale": 2.0}')
    (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
    assert (asset.id, asset.category, asset.licence, asset.placement) == (
        "table_lamp_a",
        "table_lamp",
        "CC-BY-4.0",
        "object",
    )
    assert asset.size == pytest.approx((0.4, 0.2, 0.8)), "glTF's z is our x, its y our z"
    assert asset.mass == pytest.approx(3.0)
    (mine / "asset.json").write_text('{"color": "red"}')
    with pytest.raises(InputError, match="color"):
        import_folder(tmp_path / "mine", tmp_path / "models")


def test_model_files_prefers_urdf_over_meshes(folder: Path) -> None:
    trimesh.creation.box().export(folder / "bottom_cabinet" / "Oak 1" / "part.obj")
    trimesh.creation.box().export(folder / "bottom_cabinet" / "single.obj")
    found = discover(folder, [".urdf", ".glb", ".obj"])
    assert [(one.path.name, one.name) for one in found] == [("cab.urdf", "Oak 1"), ("single.obj", "single")]
    assert snake_case(" Bottom-Cabinet 3") == "bottom_cabinet_3"


def test_empty_and_missing_folders(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a folder"):
        import_folder(tmp_path / "gone", tmp_path / "models")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="holds no model"):
        import_folder(tmp_path / "empty", tmp_path / "models")


def test_odd_models_do_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mine, away = tmp_path / "mine", tmp_path / "away.obj"
    for name, size in (("good", (0.3, 0.2, 0.1)), ("cursed", (0.31, 0.2, 0.1))):
        (mine / "box").mkdir(parents=True, exist_ok=True)
        trimesh.creation.box(size).export(mine / "box" / f"{name}.obj")
    trimesh.creation.box((0.3, 0.3, 0.3)).export(away)
    (mine / "box" / "link.obj").symlink_to(away)
    in_mm = CABINET.replace('"0.02 0.58 0.7"', '"20 580 700"').replace('"0.01 -0.29 0"', '"10 -290 0"')
    write_cabinet(mine, in_mm)
    (mine / "box" / "nan.xml").write_text('<mujoco><worldbody><geom type="box" size="nan 1 1"/></worldbody></mujoco>')
    believable = imports.check_believable

    def check(robot: RobotModel, path: Path) -> None:
        if path.stem == "cursed":
            raise MemoryError("196 GiB")
        believable(robot, path)

    monkeypatch.setattr(imports, "check_believable", check)
    monkeypatch.chdir(tmp_path)
    assert [asset.id for asset in import_folder(mine, tmp_path / "models")] == ["box_good"]
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith("left out: ")]
    assert len(said) == 4
    for words in (
        "link.obj: is a link out of mine/",
        "cursed.obj: takes more than 3000 MB of memory to read",
        "m large",
    ):
        assert any(words in line for line in said), words
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists(), "what it warns of is told in its error"


def test_two_bodies_are_two_hulls() -> None:
    left, right = trimesh.creation.box(), trimesh.creation.icosphere(2)
    right.apply_translation([5, 0, 0])
    pieces = convex_pieces(trimesh.util.concatenate([left, right]))
    assert sorted(round(piece.volume, 1) for piece in pieces) == [1.0, round(right.volume, 1)]


def test_a_kitchen_as_a_package_ships_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    urdf = write_kitchen(tmp_path / "packages")
    mine = tmp_path / "mine" / "bottom_cabinet"
    mine.mkdir(parents=True)
    (mine / "kitchen").symlink_to(urdf.parent)
    with pytest.raises(InputError, match="holds no model"):
        import_folder(tmp_path / "mine", tmp_path / "models")
    assert "kitchen: is a link out of mine/" in capsys.readouterr().err
    asset = import_model(urdf, tmp_path / "packages", tmp_path / "models")
    assert (asset.doors, asset.drawers) == (2, 2)
    assert [joint.handle_link for joint in asset.joints] == [
        "door_left_handle", "drawer_left_nob", "door_right_handle", "drawer_right_nob"
    ]  # fmt: skip
    assert all(joint.lower == 0 and joint.upper > 0.3 for joint in asset.joints)
    assert asset.size == pytest.approx((0.656, 0.76, 0.78), abs=0.001)
    robot = read_urdf(tmp_path / "models" / asset.id / "model.urdf", tmp_path / "models")
    for joint in asset.joints:
        shut, open_ = (link_frames(robot, share)[joint.handle_link or joint.link] for share in (0.0, 0.3))
        assert open_[0, 3] > shut[0, 3] + 0.05, f"{joint.name} opens inwards"
    urdf.unlink()
    assert material_of(tmp_path / "models" / asset.id / "meshes" / "body.glb").baseColorTexture is not None


def test_specks_are_left_out_and_thin_pieces_made_thick_enough(folder: Path, tmp_path: Path) -> None:
    path = folder / "bottom_cabinet" / "Oak 1" / "cab.urdf"
    text = path.read_text().replace('<sphere radius="0.02"/>', '<sphere radius="0.000001"/>')
    path.write_text(text.replace('size="0.02 0.58 0.7"', 'size="0.00001 0.58 0.7"'))
    (asset,) = import_folder(folder, tmp_path / "models")
    robot = read_urdf(tmp_path / "models" / asset.id / "model.urdf", tmp_path)
    assert robot.links["door_knob"].visuals == []
    (panel,) = robot.links["door"].collisions
    assert panel.extents == pytest.approx((1e-4, 0.58, 0.7))


def test_masses_are_kilograms_whatever_the_unit_of_length(folder: Path, tmp_path: Path) -> None:
    (asset,) = import_folder(folder, tmp_path / "models")
    write_notes = (folder / "bottom_cabinet" / "Oak 1" / "asset.json").write_text
    write_notes('{"scale": 0.5}')
    import_folder(folder, tmp_path / "small")
    read = [read_urdf(tmp_path / name / asset.id / "model.urdf", tmp_path) for name in ("models", "small")]
    (body, tray), (small_body, small_tray) = ([robot.links[name] for name in ("body", "tray")] for robot in read)
    assert small_body.mass == body.mass == 12, "told by the file"
    assert np.allclose(small_body.inertia, body.inertia / 4, rtol=1e-4)
    assert tray.mass / 8.1 < small_tray.mass < tray.mass / 3.9, "estimated at its real size"


def test_textured_objects_in_centimetres(tmp_path: Path) -> None:
    place = tmp_path / "mine" / "mug" / "blue"
    textured_box((8.0, 9.0, 10.0), place, "mug")
    (place / "asset.json").write_text('{"scale": 0.01, "placement": "object"}')
    (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
    assert asset.size == pytest.approx((0.08, 0.09, 0.10))
    area = 2 * (0.08 * 0.09 + 0.08 * 0.10 + 0.09 * 0.10)
    assert asset.mass == pytest.approx(area / 2 * 0.018 * 500, rel=1e-3)
    material = material_of(tmp_path / "models" / asset.id / "meshes" / "base.glb")
    assert material.baseColorTexture is not None
    assert material.metallicFactor == 0.0


def material_of(glb: Path) -> trimesh.visual.material.PBRMaterial:
    return next(iter(trimesh.load_scene(glb).geometry.values())).visual.material
