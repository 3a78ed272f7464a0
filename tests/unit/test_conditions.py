"""How test assets are shown: a depth camera's noise, a camera off the assumed pose, a robot parked elsewhere."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from roomkin.stages.config.evaluation import EvaluationConfig, SceneOptions, SensingOptions, SkillOptions
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.evaluation.vector_env import make_sensing, move_robot
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.observation import Sensing, displace_pose, with_noise
from tests.unit.demo_assets import cabinet

SEED = 2**31 + 3


def test_noise_moves_points_along_their_rays_by_what_a_depth_camera_errs() -> None:
    picture = np.zeros((100, 100, 4), np.int16)
    picture[..., 0], picture[..., 2], picture[..., 3] = 500, -1000, 9
    noisy = with_noise(picture, np.random.default_rng(0))
    assert (noisy[..., 3] == 9).all()
    error = -noisy[..., 2] - 1000.0
    assert np.std(error) == pytest.approx(1000 * (0.0012 + 0.0019 * 0.6**2), rel=0.1)  # and rounded to millimetres
    np.testing.assert_allclose(noisy[..., 0], -noisy[..., 2] / 2, atol=1.0)


def test_a_displaced_camera_is_as_far_off_as_asked_elsewhere_in_every_episode() -> None:
    pose = np.eye(4)
    moved = [displace_pose(pose, seed, 0, (0.01, np.deg2rad(2))) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(moved[0], moved[1])
    assert not np.allclose(moved[0], moved[2])
    for one in moved:
        assert np.linalg.norm(one[:3, 3]) == pytest.approx(0.01)
        assert Rotation.from_matrix(one[:3, :3]).magnitude() == pytest.approx(np.deg2rad(2))


def test_parking_is_of_the_robot_alone() -> None:
    options = move_robot(TaskConfig(), SceneOptions(robot_init_noise=(0.15, 20.0)))
    assert options.base_xy == 0.15 and options.base_yaw == pytest.approx(np.deg2rad(20))
    changed = {key for key, value in options if value != getattr(TaskConfig(), key)}
    assert changed == {"base_xy", "base_yaw"}
    assert move_robot(TaskConfig(), SceneOptions()) == TaskConfig()


def test_what_a_policy_sees_is_off_and_the_world_is_not(tmp_path: Path) -> None:
    cabinet(tmp_path / "cabinet_0")
    seen, joints = [], []
    for sensing in (None, make_sensing(SensingOptions(camera_error=(0.05, 0.0))), Sensing(depth_noise=True)):
        where = tmp_path / "cabinet_0"
        env = EnvWrapper("door", where, "door_0_joint", None, TaskConfig(), vary_scale=False, sensing=sensing)
        seen.append(env.reset(SEED)["point_cloud"])
        joints.append(env.env.base_from_asset())
        env.close()
    np.testing.assert_array_equal(joints[0], joints[1])
    true, shifted, noisy = (cloud[cloud[:, 3] == 0, :3] for cloud in seen)
    assert np.linalg.norm(shifted.mean(axis=0) - true.mean(axis=0)) == pytest.approx(0.05, abs=0.015)
    assert np.linalg.norm(noisy.mean(axis=0) - true.mean(axis=0)) < 0.01 and not np.array_equal(noisy, true)
    np.testing.assert_array_equal(seen[1][seen[1][:, 3] == 1], seen[0][seen[0][:, 3] == 1])  # fingers are known


def test_a_condition_says_only_what_differs() -> None:
    made = EvaluationConfig(conditions={"mujoco": {"simulator": "mujoco"}})  # type: ignore[dict-item]
    assert made.conditions["mujoco"].model_dump(exclude_unset=True) == {"simulator": "mujoco"}
    noisy = EvaluationConfig(simulator="mujoco", conditions={"noise": SensingOptions(depth_noise=True)}).under("noise")
    assert noisy.depth_noise and noisy.simulator == "mujoco"


def test_the_skill_which_looks_at_nothing_is_not_told_how_cameras_err() -> None:
    assert not {"depth_noise", "camera_error"} & set(SkillOptions.model_fields)
