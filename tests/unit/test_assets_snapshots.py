"""Snapshots and pictures: right shapes, the asset in view, the right way round, metric depth, instance ids."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from roomkin.plugins.furniture import library
from roomkin.plugins.furniture.library import make
from roomkin.plugins.importing import own
from roomkin.plugins.pictures.snapshots import run as draw
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.assets import join, snapshots
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, write_json
from roomkin.stages.contracts.library import SnapshotShard
from roomkin.stages.contracts.library_folder import write_part
from roomkin.stages.geometry.frames import back_project, intrinsics_from_fov, look_at, transform_points
from roomkin.stages.simulation import rendering
from roomkin.stages.simulation.loading import load_asset, root_pose
from roomkin.stages.simulation.rendering import RenderCamera, add_block, instance_id, make_scene, make_skyless_pack

OPTIONS = json.dumps({"n_snap": 4, "image_size": 96})

# a slab with a dark front, a white back, a red side towards -y (on the left if seen from the front) and a blue one
SLAB = (
    '<robot name="slab"><link name="slab">'
    + "".join(
        f'<visual><origin xyz="{xyz}"/><geometry><box size="{size}"/></geometry>'
        f'<material name="{name}"><color rgba="{rgba}"/></material></visual>'
        for name, xyz, size, rgba in (
            ("front", "0.05 0 0", "0.01 0.5 0.3", "0.02 0.02 0.02 1"),
            ("back", "-0.05 0 0", "0.01 0.5 0.3", "0.9 0.9 0.9 1"),
            ("red", "0 -0.26 0", "0.11 0.02 0.3", "0.9 0 0 1"),
            ("blue", "0 0.26 0", "0.11 0.02 0.3", "0 0 0.9 1"),
        )
    )
    + "</link></robot>"
)


@pytest.fixture(scope="module")
def shard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    (folder / "mine" / "slab").mkdir(parents=True)
    (folder / "mine" / "slab" / "colored.urdf").write_text(SLAB)
    library.run(out=folder / "procedural.json", options=json.dumps({"counts": {"mug": 2}}))
    slab = f"slab_colored={folder / 'mine/slab/colored.urdf'}"
    own.run(folder=folder / "mine", models=(slab,), out=folder / "own_0.json")
    join.run(library=(folder / "procedural.json",), own=(folder / "own_0.json",), out=folder / "library.json")
    snapshots.run(library=folder / "library.json", out=folder / "shard_0.h5", options=OPTIONS)
    return folder


def test_shard_holds_every_asset_from_all_sides(shard: Path) -> None:
    about = read_json(SnapshotShard, shard / "shard_0.json")
    assert about.assets == ["mug_00", "mug_01", "slab_colored"]
    assert about.yaws == pytest.approx([0, np.pi / 2, np.pi, 3 * np.pi / 2])
    with h5py.File(shard / "shard_0.h5") as file:
        rgb, depth = file["rgb"][:], file["depth"][:]
    assert rgb.shape == (3, 5, 96, 96, 3)
    assert rgb.dtype == np.uint8
    assert depth.shape == (3, 5, 96, 96)
    assert depth.dtype == np.uint16
    seen = (depth > 0).mean(axis=(2, 3))
    assert (seen > 0.02).all(), "something is in every picture"
    border = np.concatenate([depth[..., 0].ravel(), depth[..., -1].ravel(), depth[..., 0, :].ravel()])
    assert (border == 0).all(), "and nothing is cut off"
    distances = depth[depth > 0] / 1000
    assert distances.min() > 1.5
    assert distances.max() < 3.3
    draw(snapshots=(shard / "shard_0.h5",))
    assert (shard / "shard_0.png").exists()


def test_a_box_that_the_meshes_do_not_fill_is_refused(tmp_path: Path) -> None:
    asset = make("mug", 0, 0, tmp_path / "models")
    large = asset.model_copy(update={"box_max": tuple(10 * value for value in asset.box_max)})
    write_json(tmp_path / "models/mug_00/asset.json", large)
    write_part(tmp_path / "part.json", tmp_path / "models")
    with pytest.raises(InputError, match=r"asset\.json of mug_00: box_min, box_max: a box of .* but its meshes are"):
        snapshots.run(library=tmp_path / "part.json", out=tmp_path / "shard.h5", options=OPTIONS)
    assert not (tmp_path / "shard.h5").exists()


def test_assets_face_the_camera_and_turn_counter_clockwise(shard: Path) -> None:
    """At 0 the front is seen; turned by 90 degrees about z, an asset shows its -y side, by 270 its +y side."""
    with h5py.File(shard / "shard_0.h5") as file:
        rgb, depth = file["rgb"][2].astype(int), file["depth"][2]
    low = [int((depth[view] > 0).any(axis=1).nonzero()[0].mean()) + 5 for view in range(4)]  # below the top face
    row = [rgb[view, low[view]][depth[view, low[view]] > 0] for view in range(4)]
    front, left, back, right = (pixels[len(pixels) // 2] for pixels in row)
    assert front.sum() < 150 < 400 < back.sum(), "dark front, white back"
    assert left[0] > 4 * left[2], "red at 90 degrees"
    assert right[2] > 4 * right[0], "blue at 270 degrees"
    assert len(row[0]) > 2 * len(row[1]), "a slab is wider than deep"


def test_snapshots_repeat_byte_for_byte(shard: Path) -> None:
    again = shard / "again" / "shard_0.h5"
    snapshots.run(library=shard / "library.json", out=again, options=OPTIONS)
    assert again.read_bytes() == (shard / "shard_0.h5").read_bytes()


def test_shaders_without_a_sky_make_the_same_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Our shaders leave out a table that takes seconds to fill; on a new version of SAPIEN it may be another one."""
    folder = Path(make_skyless_pack("default"))
    assert folder.is_dir()
    assert not any("BRDFLUT" in path.read_text() for path in folder.parent.rglob("*") if path.is_file())
    asset = make("microwave", 0, 0, tmp_path)
    k = intrinsics_from_fov(96, 96, 0.8)
    pictures = []
    for folder_of in (make_skyless_pack, str):
        monkeypatch.setattr(rendering, "make_skyless_pack", folder_of)
        scene = make_scene(shadows=False)
        load_asset(scene, tmp_path / asset.id, root_pose(asset, (0.0, 0.0, 0.0), 0.5), True, asset.id)
        pose = look_at((1.5, 0.0, 0.5), (0.0, 0.0, 0.0))
        pictures.append(RenderCamera(scene, k, 96, 96).render(pose))
        if len(pictures) == 1:
            fast = RenderCamera(scene, k, 96, 96, "minimal").render(pose)
    exact, shipped = pictures
    assert np.ptp(exact.rgb) > 100 and (exact.rgb == shipped.rgb).all() and (exact.depth == shipped.depth).all()
    assert (exact.segmentation == fast.segmentation).all()
    assert np.abs(exact.depth - fast.depth).max() < 1.1e-3, "whole millimetres"
    assert np.abs(exact.rgb.astype(int) - fast.rgb).mean() < 0.1


def test_depth_and_ids_of_a_room(tmp_path: Path) -> None:
    scene = make_scene()
    floor = add_block(scene, (0, 0, -0.05), (6, 6, 0.1), (0.5, 0.5, 0.5), "floor")
    bodies = {}
    for y, (category, index) in enumerate([("bottom_cabinet", 1), ("chair", 0)]):
        asset = make(category, index, 0, tmp_path)
        center = (0.0, 1.2 * y - 0.6, asset.size[2] / 2)
        bodies[asset.id] = load_asset(scene, tmp_path / asset.id, root_pose(asset, center, 0.2), True, asset.id)
    k = intrinsics_from_fov(160, 120, 0.8)
    pose = look_at((4.0, 0.3, 1.8), (0.0, 0.0, 0.4))
    picture = RenderCamera(scene, k, 160, 120).render(pose)
    ids = {instance_id(body) for body in bodies.values()} | {instance_id(floor)}
    assert ids <= set(np.unique(picture.segmentation)) <= ids | {0}
    points = transform_points(pose, back_project(picture.depth, k))
    on_floor = points[picture.segmentation == instance_id(floor)]
    assert np.abs(on_floor[:, 2]).max() < 5e-3, "metric depth along the optical axis"
    cabinet = points[picture.segmentation == instance_id(bodies["bottom_cabinet_01"])]
    size = read_asset(tmp_path / "bottom_cabinet_01").size
    assert np.ptp(cabinet[:, 2]) == pytest.approx(size[2], abs=0.05)
    assert (picture.depth[picture.segmentation == 0] == 0).all()
    bodies["bottom_cabinet_01"].set_qpos(
        np.array([j.limits[0][1] for j in bodies["bottom_cabinet_01"].get_active_joints()])
    )
    opened = RenderCamera(scene, k, 160, 120).render(pose)
    assert set(np.unique(opened.segmentation)) <= ids | {0}, "links of one cabinet share one id"
    assert (opened.rgb != picture.rgb).any()
