"""The same cabinet with joints that count from elsewhere: nothing of a task changes with the lower limit."""

from pathlib import Path

import numpy as np
import pytest
import torch
import trimesh

from roomkin.plugins.mujoco.environment import MujocoTaskEnv
from roomkin.plugins.mujoco.world import MODEL
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.planning.clearance import make_handle_path
from roomkin.stages.simulation.target import Target
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.base_placement import find_success_opening
from tests.unit.demo_assets import cabinet, shifted

SHIFT = {"door": 0.4, "drawer": -0.25}  # what is added to both limits: radians, metres
FULL = TaskConfig(points=64, success_fraction=0.9)


@pytest.fixture(scope="module", params=["door", "drawer"])
def both(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[EnvWrapper, EnvWrapper]:
    """The task with the plain cabinet and with the one whose limits are moved."""
    role, folder = request.param, tmp_path_factory.mktemp("cabinets") / request.param
    cabinet(folder, layout=[[role]])
    tasks = [
        EnvWrapper(role, each, f"{role}_0_joint", None, FULL, render=False, vary_scale=False)
        for each in (folder, shifted(folder, SHIFT[role]))
    ]
    for task in tasks:
        task.place(3)
    return tasks[0], tasks[1]


def test_limits_are_moved(both: tuple[EnvWrapper, EnvWrapper]) -> None:
    plain, other = (task.env.unwrapped.target for task in both)
    by = SHIFT["door" if plain.revolute else "drawer"]
    assert (plain.lower, other.lower, other.upper - plain.upper) == pytest.approx((0, by, by), abs=1e-4)
    assert other.axis == pytest.approx(plain.axis, abs=1e-4)


def test_an_episode_begins_closed(both: tuple[EnvWrapper, EnvWrapper]) -> None:
    for task in both:
        env = task.env.unwrapped
        env.object.set_qpos(env.object.get_qlimits()[..., 1])
        task.place(3)
        assert float(env.measure_opening()[0]) == pytest.approx(0, abs=1e-4)
        assert task.env.unwrapped.target.reference == pytest.approx(both[0].env.unwrapped.target.reference, abs=1e-3)


def test_success_and_openings_are_the_same(both: tuple[EnvWrapper, EnvWrapper]) -> None:
    thresholds = []
    for task in both:
        task.place(3)
        env = task.env.unwrapped
        target = env.target
        thresholds.append(env.success_opening())
        for opened in (0.2, 0.6, 1.0):
            env.object.set_qpos(torch.tensor([[target.lower + opened * (target.upper - target.lower)]]))
            assert float(env.measure_opening()[0]) == pytest.approx(opened, abs=1e-3)
            assert bool(env.check_success()[0]) == (opened >= thresholds[0])
    assert thresholds[0] == pytest.approx(thresholds[1], abs=1e-4) and thresholds[0] < 0.9


def test_the_hand_follows_the_handle_alike(both: tuple[EnvWrapper, EnvWrapper]) -> None:
    grasp = make_transform(np.eye(3), [0.3, 0.1, 0.4])
    ways = []
    for task in both:
        target = task.env.unwrapped.target
        ways.append(make_handle_path(target, grasp, target.lower, target.lower + 0.2, follow=0.7))
    assert ways[0] == pytest.approx(ways[1], abs=1e-3) and ways[0][0] == pytest.approx(grasp, abs=1e-6)


def test_openings_are_the_same_in_mujoco(tmp_path: Path) -> None:
    cabinet(tmp_path / "cab", layout=[["door"]])
    task = MujocoTaskEnv("door", shifted(tmp_path / "cab", SHIFT["door"]), "door_0_joint", None, FULL, render=False)
    for opened in (0.0, 0.1):
        task.place(3)
        joint = task.data.joint(f"{MODEL}door_0_joint")
        low, high = task.model.joint(f"{MODEL}door_0_joint").range
        assert low == pytest.approx(SHIFT["door"], abs=1e-4)
        joint.qpos, joint.qvel = low + opened * (high - low), 0.0
        task.act(np.array([0, 0, 0, 0, 0, 0, 1], np.float32))
        assert task.opened == pytest.approx(opened, abs=0.02)
    task.close()


@pytest.mark.parametrize(("revolute", "span", "opened"), [(True, np.pi, 1 / 3), (True, 1.0, 0.5), (False, 0.1, 0.5)])
def test_what_moves_little_is_open_at_half_of_its_range(revolute: bool, span: float, opened: float) -> None:
    """A drawer of 10 cm is never open by the 15 cm that count for a deep one."""
    empty = trimesh.Trimesh()
    target = Target(0, revolute, np.array([1.0, 0, 0]), np.zeros(3), 0.4, 0.4 + span, empty, empty, None)
    assert find_success_opening(target, TaskConfig()) == pytest.approx(opened)
