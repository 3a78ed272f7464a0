"""What the policy's cameras see, with a renderer: the right points at the right place, from every mount."""

from collections.abc import Sequence
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import sapien
from mani_skill.utils.wrappers.gymnasium import CPUGymWrapper

import roomkin.stages.tasks  # noqa: F401
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.simulation.loading import load_asset
from roomkin.stages.simulation.observation import PICTURE, depth_shaders
from roomkin.stages.simulation.rendering import make_scene, make_skyless_pack
from roomkin.stages.tasks.door import TASK
from roomkin.stages.tasks.environment import OpenTaskEnv
from roomkin.stages.tasks.observation import WRIST, MountedCamera, other_shoulder, shoulder
from tests.unit.demo_assets import cabinet

OPTIONS = TaskConfig(points=256, camera_size=64)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cabinet with two doors."""
    folder = tmp_path_factory.mktemp("assets") / "two"
    cabinet(folder, layout=[["door", "door"]])
    return folder


class ThreeEyes(OpenTaskEnv):
    """Doors seen from both shoulders and from the wrist."""

    def cameras(self) -> Sequence[MountedCamera]:
        return [shoulder(self.options), other_shoulder(self.options), WRIST]


def test_our_shaders_see_what_sapiens_see(folder: Path) -> None:
    scene = make_scene()
    load_asset(scene, folder, sapien.Pose(), True, "two")
    config, pictures = depth_shaders(), []
    for pack in (config.shader_pack, make_skyless_pack("minimal")):
        sapien.render.set_camera_shader_dir(pack)
        camera = sapien.render.RenderCameraComponent(64, 64)
        camera.set_fovy(1.0)
        entity = sapien.Entity()
        entity.add_component(camera)
        scene.add_entity(entity)
        entity.set_pose(sapien.Pose([1.2, 0.1, 0.6], [0, 0, 0, 1]))
        scene.update_render()
        camera.take_picture()
        pictures.append(camera.get_picture(PICTURE))
    sapien.render.set_camera_shader_dir(make_skyless_pack("default"))
    ours, theirs = pictures
    assert ours.dtype == np.int16 and len(np.unique(ours[..., 3])) >= 3 and np.ptp(ours[..., 2]) > 500
    assert np.array_equal(ours, theirs)
    names = [path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")]
    assert sum(name.startswith("llvmpipe") for name in names) <= 1, "one thread renders"


def test_every_camera_adds_points_of_the_target_where_it_is(folder: Path) -> None:
    env = ThreeEyes(task=TASK, asset_folder=folder, joint="door_1_joint", options=OPTIONS, reward_mode="none")
    env.reset(seed=4)
    env.scene.update_render(update_sensors=True, update_human_render_cameras=False)
    pictures, joints = env.rig.capture(env._sensors), env.agent.robot.get_qpos()[0].numpy().astype(float)
    bounds = env.target.moving.bounds + np.array([[-0.004], [0.004]])  # a picture is in millimetres
    for number, camera in enumerate(env.cameras()):
        alone = [picture if i == number else np.zeros_like(picture) for i, picture in enumerate(pictures)]
        cloud = env.rig.observation(joints, alone, env.seen_ids(), 0)["point_cloud"]
        points = cloud[cloud[:, 3] == 0, :3]
        assert len(np.unique(points, axis=0)) > 40, camera.name
        local = transform_points(invert_transform(env.base_from_asset()), points)
        assert ((local > bounds[0]) & (local < bounds[1])).all(), camera.name
    (merged,) = env.observe()
    scene = merged["point_cloud"][merged["point_cloud"][:, 3] == 0, :3]
    assert len(np.unique(scene, axis=0)) == OPTIONS.points - OPTIONS.finger_points
    env.close()


def test_gym_make_alone(folder: Path) -> None:
    with pytest.raises(InputError, match="has no drawer"):
        gymnasium.make("ACDC-OpenDrawer-v1", asset_folder=folder)
    env = gymnasium.make("ACDC-OpenDoor-v1", asset_folder=folder, options=OPTIONS)
    assert env.unwrapped.joint_name in ("door_0_joint", "door_1_joint")
    seen, _ = env.reset(seed=3)
    assert env.observation_space.contains({key: value.numpy() for key, value in seen.items()})
    assert {key: tuple(value.shape) for key, value in seen.items()} == {"point_cloud": (1, 256, 4), "proprio": (1, 9)}
    _, reward, terminated, truncated, info = env.step(env.action_space.sample() * 0)
    assert reward.item() == 0.0 and not (terminated | truncated).item() and not info["official_success"].item()
    env.unwrapped.object.set_qpos(env.unwrapped.object.get_qlimits()[..., 1])
    _, reward, terminated, _, info = env.step(env.action_space.sample() * 0)
    assert reward.item() == 1.0 and terminated.item() and info["success"].item() and info["official_success"].item()
    env.close()


def test_gym_vectors(folder: Path) -> None:
    """On a CPU ManiSkill has one environment a scene: several are gymnasium's vector, by ManiSkill's own wrapper."""
    envs = gymnasium.make_vec(
        "ACDC-OpenDoor-v1",
        num_envs=2,
        vectorization_mode="sync",
        wrappers=(CPUGymWrapper,),
        asset_folder=folder,
        options=OPTIONS,
    )
    seen, _ = envs.reset(seed=[3, 4])
    assert seen["point_cloud"].shape == (2, 256, 4) and not np.allclose(*seen["point_cloud"])
    seen, reward, terminated, truncated, _ = envs.step(np.zeros(envs.action_space.shape, np.float32))
    assert seen["proprio"].shape == (2, 9) and reward.shape == terminated.shape == truncated.shape == (2,)
    assert envs.observation_space.contains(seen)
    envs.close()
