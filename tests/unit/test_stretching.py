"""Assets stretched in memory against the same assets stretched by way of files; no renderer."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
import sapien
import trimesh
from mani_skill.utils.geometry.trimesh_utils import get_component_meshes
from sapien.physx import PhysxArticulation

from roomkin.plugins.furniture.library import make
from roomkin.plugins.importing.tests.own_models import import_folder
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.articulated.resizing import resize_model
from roomkin.stages.articulated.urdf_writer import write_urdf
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.simulation.loading import ParsedAsset, load_asset, physics_scene
from roomkin.stages.simulation.stretching import stretch_builder
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.environment import OpenTaskEnv
from roomkin.stages.tasks.filmed import FilmedEnv
from tests.unit.articulated_models import write_cabinet
from tests.unit.demo_assets import cabinet

SCALE = np.array([1.25, 0.75, 1.1])


def inertia(link: sapien.physx.PhysxArticulationLinkComponent) -> np.ndarray:
    """(3, 3) about the center of mass, in the link's axes."""
    axes = link.cmass_local_pose.to_transformation_matrix()[:3, :3]
    return np.asarray(axes @ np.diag(link.inertia) @ axes.T)


def bounds(link: sapien.physx.PhysxArticulationLinkComponent) -> np.ndarray:
    """(2, 3) of the shapes of a link, in the world (SAPIEN's own boxes are wrong for turned hulls with a scale)."""
    mesh = trimesh.util.concatenate(get_component_meshes(link))
    return np.asarray(mesh.apply_transform(link.pose.to_transformation_matrix()).bounds)


def same(one: sapien.physx.PhysxArticulation, other: sapien.physx.PhysxArticulation) -> None:
    """Links, joints and masses agree, closed and half open."""
    for half in (0.0, 0.5):
        for body in (one, other):
            limits = np.array([joint.limits[0] for joint in body.active_joints])
            body.set_qpos((limits[:, 0] + half * (limits[:, 1] - limits[:, 0])).astype(np.float32))
        for a, b in zip(one.links, other.links, strict=True):
            assert a.name == b.name
            assert np.allclose(bounds(a), bounds(b), atol=1e-3), a.name  # PhysX leaves out vertices of a round hull
            assert a.mass == pytest.approx(b.mass, rel=1e-3)
            assert np.allclose(a.cmass_local_pose.p, b.cmass_local_pose.p, atol=1e-4)
            assert np.allclose(inertia(a), inertia(b), rtol=2e-3, atol=1e-5), a.name
    for a, b in zip(one.active_joints, other.active_joints, strict=True):
        assert np.allclose(a.limits, b.limits, atol=1e-4), a.name


def load_by_file(scene: sapien.Scene, folder: Path, out: Path) -> PhysxArticulation | sapien.Entity:
    asset = read_asset(folder)
    write_urdf(resize_model(folder, asset, (np.array(asset.size) * SCALE).tolist(), by_recipe=False).robot, out)
    return load_asset(scene, out, sapien.Pose(), True, "file", asset=asset)


@pytest.mark.parametrize("kind", ["procedural", "imported"])
def test_a_stretched_asset_is_that_of_the_files(kind: str, tmp_path: Path) -> None:
    if kind == "procedural":
        folder = tmp_path / make("bottom_cabinet", 1, 0, tmp_path).id
    else:
        write_cabinet(tmp_path / "mine")
        (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
        folder = tmp_path / "models" / asset.id
    asset = read_asset(folder)
    by_file = load_by_file(scene := physics_scene(), folder, tmp_path / "stretched")
    in_memory = load_asset(scene, folder, sapien.Pose(), True, "memory", SCALE)
    same(in_memory, by_file)


def test_what_is_turned_by_a_quarter_is_stretched_in_memory(tmp_path: Path) -> None:
    cabinet(tmp_path / "turned")
    path = tmp_path / "turned" / "model.urdf"
    tree = ElementTree.parse(path)
    origin = tree.getroot().findall("link/collision/origin")[0]
    origin.set("rpy", f"{np.pi / 2} 0 {np.pi / 2}")  # x to y to z to x: no two axes change places
    tree.write(path)
    scene = physics_scene()
    assert stretch_builder(ParsedAsset(scene.create_urdf_loader(), tmp_path / "turned", True).builder(), SCALE)
    by_file = load_by_file(scene, tmp_path / "turned", tmp_path / "f")
    same(load_asset(scene, tmp_path / "turned", sapien.Pose(), True, "memory", SCALE), by_file)


def test_what_is_askew_is_stretched_by_way_of_files(tmp_path: Path) -> None:
    cabinet(tmp_path / "askew")
    path = tmp_path / "askew" / "model.urdf"
    tree = ElementTree.parse(path)
    tree.getroot().findall("link/collision/origin")[0].set("rpy", "0.3 0 0")
    tree.write(path)
    scene = physics_scene()
    parsed = ParsedAsset(scene.create_urdf_loader(), tmp_path / "askew", True)
    assert stretch_builder(parsed.builder(), SCALE) is None
    assert stretch_builder(parsed.builder(), np.full(3, 1.1)) is not None
    by_file = load_by_file(scene, tmp_path / "askew", tmp_path / "f")
    same(load_asset(scene, tmp_path / "askew", sapien.Pose(), True, "memory", SCALE), by_file)


def test_a_body_without_joints_is_stretched(tmp_path: Path) -> None:
    make("mug", 0, 0, tmp_path)
    asset = read_asset(tmp_path / "mug_00")
    body = load_asset(physics_scene(), tmp_path / "mug_00", sapien.Pose(), False, "mug", SCALE)
    shapes = body.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent)
    low, high = shapes.compute_global_aabb_tight()
    assert np.allclose(high - low, np.array(asset.size) * SCALE, atol=3e-3)


def test_every_episode_has_the_scale_of_its_seed_and_the_scene_stays(tmp_path: Path) -> None:
    cabinet(tmp_path / "door", layout=[["door", "drawer"]])
    options = TaskConfig(scale_variants=50, base_xy=0, base_z=0, object_xy=0, object_yaw=0)
    task = EnvWrapper("door", tmp_path / "door", "door_0_joint", None, options, render=False)
    task.place(0)
    scene, seen, handles = task.env.scene, [], []
    for seed in (1, 2, 1):
        task.place(seed)
        scale, target = task.env.scales[0], task.env.target
        assert task.env.scene is scene and (scale >= 0.75).all() and (scale <= 1.25).all()
        assert target.moving.bounds[1, 2] <= 0.7 * scale[2] + 1e-6
        body = task.env.object._objs[0]
        bounds = np.array([link.compute_global_aabb_tight() for link in body.links])
        assert np.ptp(bounds[..., 2]) == pytest.approx(0.7 * scale[2], abs=1e-3)
        assert task.env.measure_opening().item() == 0.0
        seen.append(scale.tolist())
        handles.append(target.reference.tolist())
    assert seen[0] == seen[2] != seen[1] and handles[0] == handles[2] != handles[1]
    fixed = EnvWrapper("door", tmp_path / "door", "door_0_joint", None, options, render=False, vary_scale=False)
    fixed.place(1)
    assert (fixed.env.scales == 1).all()
    for made in (task, fixed):
        made.close()


@pytest.fixture(scope="module")
def door(tmp_path_factory: pytest.TempPathFactory) -> OpenTaskEnv:
    folder = tmp_path_factory.mktemp("door")
    cabinet(folder)
    task = EnvWrapper("door", folder, "door_0_joint", None, TaskConfig(), render=False)
    task.place(0)
    return task.env


def test_a_scene_is_built_again_before_its_ids_run_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cabinet(tmp_path / "door")
    task = EnvWrapper("door", tmp_path / "door", "door_0_joint", None, TaskConfig(), render=False)
    task.place(0)
    scene = task.env.scene
    monkeypatch.setattr("roomkin.stages.tasks.environment.LARGEST_ID", 1)
    task.place(1)
    assert task.env.scene is not scene and task.env.measure_opening().item() == 0.0
    task.close()


@pytest.mark.parametrize(("on_gpu", "other", "largest", "again"), [
    (False, False, 9999, False), (False, True, 9999, False), (False, False, 1, True),
    (True, False, 9999, False), (True, True, 9999, True), (True, False, 1, True),
])  # fmt: skip
def test_what_a_scene_is_built_again_for(
    on_gpu: bool, other: bool, largest: int, again: bool, door: OpenTaskEnv, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(OpenTaskEnv, "gpu_sim_enabled", on_gpu)
    monkeypatch.setattr("roomkin.stages.tasks.environment.LARGEST_ID", largest)
    monkeypatch.setattr(FilmedEnv, "reset", lambda _, seed, options: options)
    monkeypatch.setattr(door, "asset_folder", Path("other") if other else door.asset_folder)
    assert door.reset(0, {"mine": 1}) == ({"mine": 1, "reconfigure": True} if again else {"mine": 1})


def test_another_asset_comes_into_the_same_scene(tmp_path: Path) -> None:
    cabinet(tmp_path / "door")
    cabinet(tmp_path / "two", layout=[["door", "door"]], size=[0.5, 0.9, 0.8])
    options = TaskConfig()
    task = EnvWrapper("door", tmp_path / "door", "door_0_joint", None, options, render=False)
    task.place(5)
    scene, first = task.env.scene, task.env.target.moving.bounds
    task.turn_to(tmp_path / "two", "door_1_joint", None)
    task.place(5)
    assert task.env.scene is scene and len(task.env.object.active_joints) == 2
    links = {link.entity.per_scene_id: link.name for link in task.env.object._objs[0].links}
    assert {links[i].removeprefix("scene-0-target_object_") for i in task.env.seen_ids().tolist()} == {"door_1"}
    task.turn_to(tmp_path / "door", "door_0_joint", None)
    task.place(5)
    assert np.array_equal(task.env.target.moving.bounds, first) and len(task.env.object.active_joints) == 1
    task.close()
