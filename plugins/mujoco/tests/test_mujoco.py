"""Doors and drawers in MuJoCo: the same task as in ManiSkill, in a simulator of its own."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.spatial import KDTree

from roomkin.plugins.mujoco.environment import MujocoTaskEnv
from roomkin.plugins.mujoco.world import MODEL, DepthCamera
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts import Asset, read_json
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import invert_transform, transform_points
from roomkin.stages.simulation.film_renderer import FilmRenderer
from roomkin.stages.skills import FAR, Float
from roomkin.stages.skills.motion import SkillChain
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.initial_state import sample_scale
from tests.refusals import refused
from tests.unit.demo_assets import cabinet

SEED = 2**31 + 7
STILL = np.array([0, 0, 0, 0, 0, 0, 1], np.float32)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("assets") / "cabinet_0"
    cabinet(made)
    return made


@pytest.fixture(scope="module")
def door(folder: Path) -> Iterator[MujocoTaskEnv]:
    task = MujocoTaskEnv("door", folder, "door_0_joint", None, TaskConfig(), vary_scale=False)
    yield task
    task.close()


def test_the_start_looks_as_in_maniskill_but_for_the_noise_of_depth(door: EnvWrapper, folder: Path) -> None:
    other = EnvWrapper("door", folder, "door_0_joint", None, TaskConfig(), vary_scale=False)
    ours, theirs = door.reset(SEED), other.reset(SEED)
    np.testing.assert_allclose(ours["proprio"], theirs["proprio"], atol=1e-4)
    clouds = [seen["point_cloud"][seen["point_cloud"][:, 3] == 0, :3] for seen in (ours, theirs)]
    for one, two in (clouds, clouds[::-1]):
        distances, _ = KDTree(two).query(one)
        assert np.median(distances) < 0.012 and np.quantile(distances, 0.98) < 0.03  # points lie 2 cm apart
    other.close()


def test_the_hand_goes_where_an_action_says_and_stays_there(door: EnvWrapper) -> None:
    door.place(SEED)
    before = door.hand()
    door.act(STILL)
    assert np.linalg.norm(door.hand()[:3, 3] - before[:3, 3]) < 0.002
    before = door.hand()
    door.act(np.array([0, 0.6, 0, 0, 0, 0, 1], np.float32))
    door.act(STILL)
    moved = door.hand()[:3, 3] - before[:3, 3]
    np.testing.assert_allclose(moved, [0, 0.03, 0], atol=0.006)


def test_the_same_seed_gives_the_same_episode(door: EnvWrapper) -> None:
    ends = []
    for _ in range(2):
        door.reset(SEED)
        for _ in range(3):
            seen = door.step(np.array([0.5, 0, -0.2, 0, 0.1, 0, -1], np.float32)).observation
        ends.append(seen)
    for key in ("point_cloud", "proprio"):
        np.testing.assert_array_equal(ends[0][key], ends[1][key])  # type: ignore[literal-required]


@pytest.mark.parametrize("task", ["door", "drawer"])
def test_the_scripted_skill_opens_it(tmp_path: Path, task: str) -> None:
    where = tmp_path / "cabinet_0"
    cabinet(where, layout=[[task]])
    env = MujocoTaskEnv(task, where, f"{task}_0_joint", None, TaskConfig(), render=False, vary_scale=False)
    env.place(SEED)
    done = []

    def act(action: Float, noisy: bool, ahead: float = FAR) -> None:
        env.act(action)
        done.append(env.success)

    SkillChain(env, DemonstrationsConfig()).run(act)
    assert any(done) and env.official_success
    env.close()


def test_what_was_ajar_once_counts_for_the_official_code(door: MujocoTaskEnv) -> None:
    door.place(SEED)
    joint = door.data.joint(f"{MODEL}{door.joint}")
    found = []
    for opened in (0.0, 0.2, 0.0):
        low, high = door.model.joint(f"{MODEL}{door.joint}").range
        joint.qpos, joint.qvel = low + opened * (high - low), 0.0
        door.act(STILL)
        assert door.opened == pytest.approx(opened, abs=0.02) and not door.success
        found.append(door.official_success)
    assert found == [False, True, True]


def test_it_turns_to_another_cabinet_at_a_scale_and_is_filmed(folder: Path, tmp_path: Path) -> None:
    cabinet(tmp_path / "low", size=[0.4, 0.45, 0.5])
    task = MujocoTaskEnv("door", folder, "door_0_joint", None, TaskConfig(cloud="object"))
    task.reset(SEED)
    task.turn_to(tmp_path / "low", "door_0_joint", None)
    scale = sample_scale(SEED, task.options, task.options.scale_range)
    seen = task.reset(SEED)["point_cloud"]
    task.act(STILL)
    shown = task.env.recording([task.env.moment()])
    assert np.ptp(seen[seen[:, 3] == 0, 0]) > 0.25  # metres: the side of the cabinet, too
    assert read_json(Asset, shown.folder / "asset.json").size == pytest.approx(scale * [0.4, 0.45, 0.5], abs=1e-3)
    (picture,) = FilmRenderer().film(shown, 1)
    assert np.ptp(picture) > 200
    task.close()


def test_a_task_of_several_skills_is_refused(tmp_path: Path) -> None:
    cabinet(tmp_path / "cabinet_0", layout=[["drawer"]])
    with refused("E-MUJOCO-TASK"):
        MujocoTaskEnv("put_away_bowl", tmp_path / "cabinet_0", "drawer_0_joint", None, TaskConfig())


@pytest.mark.parametrize("fault", [ImportError, RuntimeError])
def test_without_a_device_to_render_on_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, fault: type[Exception]
) -> None:
    class GLContext:
        def __init__(self, width: int, height: int) -> None:
            raise fault("Cannot initialize a EGL device display.")

    egl = ModuleType("mujoco.egl")
    egl.GLContext = GLContext  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "mujoco.egl", egl)
    with refused("E-MUJOCO-EGL"):
        DepthCamera(None, "shoulder", 128)


def test_another_door_that_is_ajar_counts_for_the_official_code(tmp_path: Path) -> None:
    cabinet(tmp_path / "pair", layout=[["door", "door"]])
    task = MujocoTaskEnv("door", tmp_path / "pair", "door_0_joint", None, TaskConfig(), render=False, vary_scale=False)
    task.place(SEED)
    low, high = task.model.joint(f"{MODEL}door_1_joint").range
    task.data.joint(f"{MODEL}door_1_joint").qpos = low + 0.2 * (high - low)
    task.act(STILL)
    assert abs(task.opened) < 0.01 and not task.success and task.official_success
    task.close()


def test_the_cloud_lies_on_the_door_from_wherever_it_is_seen(door: MujocoTaskEnv) -> None:
    """Half a pixel beside it, what is seen at a slant is 2 mm before or behind it."""
    for seed in range(SEED, SEED + 4):
        cloud = door.reset(seed)["point_cloud"]
        points = transform_points(invert_transform(door.base_from_asset()), cloud[cloud[:, 3] == 0, :3].astype(float))
        front = points[points[:, 0] < 0.165, 0]  # the rest is its handle
        assert np.median(front) == pytest.approx(0.162, abs=0.0005)
