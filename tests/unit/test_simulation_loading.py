"""Assets in SAPIEN, their physics: poses, joints, friction, exact sizes."""

from pathlib import Path

import numpy as np
import pytest
import sapien

from roomkin.plugins.furniture.library import make
from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.articulated.resizing import resize_asset
from roomkin.stages.articulated.urdf_writer import FRICTION
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.library import Asset
from roomkin.stages.simulation.loading import load_asset, move, physics_scene, remove, root_pose
from roomkin.stages.simulation.rendering import make_scene
from tests.refusals import refused
from tests.unit.physics import add_ground, position_of


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    for category, index in (("bottom_cabinet", 1), ("mug", 0)):
        make(category, index, 0, folder)
    return folder


def collision_box(body: sapien.physx.PhysxArticulation | sapien.Entity) -> np.ndarray:
    """World bounds (2, 3) of what PhysX has of a body."""
    if isinstance(body, sapien.physx.PhysxArticulation):
        parts = [link.get_global_aabb_fast() for link in body.links]
    else:
        parts = [body.find_component_by_type(sapien.physx.PhysxRigidDynamicComponent).get_global_aabb_fast()]
    return np.array([np.min([low for low, _ in parts], axis=0), np.max([high for _, high in parts], axis=0)])


def test_a_scene_steps_alike_with_and_without_a_renderer() -> None:
    assert make_scene().timestep == physics_scene().timestep == pytest.approx(0.01)


def test_root_pose_centers_the_box(models: Path) -> None:
    asset = read_asset(models / "bottom_cabinet_01")
    turned = Asset.model_validate(asset.model_dump() | {"box_min": (0, 0, 0), "box_max": (2, 1, 1)})
    pose = root_pose(turned, (5.0, 6.0, 0.5), np.pi / 2)
    assert np.allclose(pose.p, (5.5, 5.0, 0.0), atol=1e-6)
    scene = physics_scene()
    body = load_asset(scene, models / asset.id, root_pose(asset, (1.0, 2.0, 3.0), 0.0), True, "cabinet")
    box = collision_box(body)
    assert np.allclose(box.mean(axis=0), (1, 2, 3), atol=0.02)
    assert np.allclose(box[1] - box[0], asset.size, atol=0.04)


def test_articulated_assets_are_closed_and_have_friction(models: Path) -> None:
    asset = read_asset(models / "bottom_cabinet_01")
    scene = physics_scene()
    body = load_asset(scene, models / asset.id, sapien.Pose(), True, "cabinet")
    assert isinstance(body, sapien.physx.PhysxArticulation)
    assert body.name == "cabinet"
    joints = body.get_active_joints()
    assert [joint.name for joint in joints] == [joint.name for joint in asset.joints]
    assert np.allclose(body.get_qpos(), 0)
    for joint, contract in zip(joints, asset.joints, strict=True):
        assert joint.friction == pytest.approx(FRICTION)
        assert joint.damping == pytest.approx(2.0)
        assert np.allclose(joint.limits[0], (contract.lower, contract.upper), atol=1e-4)
    assert sum(link.mass for link in body.links) == pytest.approx(asset.mass, rel=1e-3)


def test_every_body_has_a_collision_number_of_its_own_and_none_that_of_the_robot(models: Path) -> None:
    scene = physics_scene()
    cabinets = [load_asset(scene, models / "bottom_cabinet_01", sapien.Pose(), True, name) for name in ("one", "two")]
    numbers = [
        {shape.get_collision_groups()[3] for link in body.links for shape in link.collision_shapes} for body in cabinets
    ]
    assert [len(each) for each in numbers] == [1, 1] and len({0}.union(*numbers)) == 3


def test_every_joint_can_be_pushed_open_alone(models: Path) -> None:
    asset = read_asset(models / "bottom_cabinet_01")
    scene = physics_scene()
    body = load_asset(scene, models / asset.id, sapien.Pose(), True, "cabinet")
    for index, joint in enumerate(asset.joints):
        force = np.zeros(len(asset.joints))
        force[index] = 15.0 if joint.part_type == "door" else 30.0
        body.set_qpos(np.zeros(len(asset.joints)))
        for _ in range(400):
            body.set_qf(force)
            scene.step()
        opened = body.get_qpos() / [j.upper for j in asset.joints]
        assert opened[index] > 0.97
        assert np.abs(np.delete(opened, index)).max() < 0.05


def test_rigid_assets_fall_unless_they_are_fixed(models: Path) -> None:
    asset = read_asset(models / "mug_00")
    scene = physics_scene()
    add_ground(scene)
    pose = root_pose(asset, (0.0, 0.0, 0.5), 0.0)
    falling = load_asset(scene, models / asset.id, pose, False, "falling")
    hanging = load_asset(scene, models / asset.id, pose * sapien.Pose([0, 1, 0]), True, "hanging")
    for _ in range(100):
        scene.step()
    assert position_of(falling)[2] == pytest.approx(0.0, abs=0.003)
    assert position_of(hanging)[2] == pytest.approx(pose.p[2], abs=1e-6)
    move(falling, sapien.Pose([0, 0, 3]))
    assert position_of(falling)[2] == 3
    remove(scene, falling)
    assert "falling" not in [entity.name for entity in scene.entities]


def test_resized_procedural_asset_is_rebuilt(models: Path, tmp_path: Path) -> None:
    folder = resize_asset(models / "bottom_cabinet_01", (0.5, 1.2, 0.7), tmp_path)
    asset = read_asset(folder)
    assert asset.size == pytest.approx((0.5, 1.2, 0.7), abs=2e-6)
    assert asset.joints[0].handle == read_asset(models / "bottom_cabinet_01").joints[0].handle
    scene = physics_scene()
    body = load_asset(scene, folder, root_pose(asset, (0, 0, 0.35), 0.0), True, "wide")
    box = collision_box(body)
    assert np.allclose(box[1] - box[0], asset.size, atol=0.04)


def test_a_broken_asset_is_one_clear_line(models: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_asset(physics_scene(), tmp_path, sapien.Pose(), True, "x")
    folder = resize_asset(models / "mug_00", (0.1, 0.13, 0.1), tmp_path)
    (folder / "model.urdf").write_text("<robot")
    with refused("E-MODEL-BROKEN"):
        load_asset(physics_scene(), folder, sapien.Pose(), True, "x")
