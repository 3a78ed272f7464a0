"""The robot stands where it always does, unless its arm can follow a door's handle from another place alone."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.furniture.library import make
from roomkin.plugins.importing import reach
from roomkin.plugins.importing.reach import find_middle_state, list_unreachable
from roomkin.plugins.importing.tests.own_models import import_model
from roomkin.plugins.importing.tests.test_fronts import box, joint
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.demonstrations.attempt import Recorder
from roomkin.stages.planning.articulation import choose_open_goals
from roomkin.stages.planning.clearance import Surroundings
from roomkin.stages.simulation.robot import REST
from roomkin.stages.skills import FAR
from roomkin.stages.skills.open import OpenSkill
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.base_placement import MOTION, NEARBY, can_follow, reachable_base
from roomkin.stages.tasks.initial_state import base_pose, nominal_root, sample_initial_state, sample_scale

OPTIONS = TaskConfig()


def fridge(folder: Path, width: float) -> Path:
    """The asset of a fridge 1.7 m high with one door, its handle a bar at the free side, a metre above the floor."""
    at = width - 0.05
    bar = box("0.02 0.02 0.4", f"0.115 {at} 0.15") + box("0.05 0.02 0.02", f"0.085 {at} 0.33")
    door = box(f"0.06 {width} 1.7", f"0.03 {width / 2} 0") + bar + box("0.05 0.02 0.02", f"0.085 {at} -0.03")
    text = (
        f'<robot name="f"><link name="body">{box(f"0.6 {width} 1.7", "-0.304 0 0.85")}</link>'
        f'<link name="door">{door}</link>'
        f"{joint('hinge', 'revolute', 'door', '0 0 -1', 2.0, f'0 {-width / 2} 0.85')}</robot>"
    )
    (folder / "theirs/fridge").mkdir(parents=True)
    (folder / "theirs/fridge/f.urdf").write_text(text)
    import_model(folder / "theirs/fridge/f.urdf", folder / "theirs", folder / "library")
    return folder / "library/fridge_f"


def cupboard(folder: Path, width: float) -> Path:
    """The asset of a low cupboard with one light door that turns by 143 degrees, its handle an upright bar."""
    at = width - 0.05
    bar = "".join(box("0.04 0.015 0.015", f"0.04 {at} {z}") for z in (0.09, -0.09))
    bar = box("0.015 0.015 0.2", f"0.062 {at} 0") + bar
    text = (
        f'<robot name="c"><link name="body">{box(f"0.5 {width} 0.7", "-0.254 0 0.35")}</link>'
        f'<link name="door">{box(f"0.02 {width} 0.7", f"0.01 {width / 2} 0") + bar}</link>'
        f"{joint('hinge', 'revolute', 'door', '0 0 -1', 2.5, f'0 {-width / 2} 0.35')}</robot>"
    )
    (folder / "theirs/cupboard").mkdir(parents=True)
    (folder / "theirs/cupboard/c.urdf").write_text(text)
    import_model(folder / "theirs/cupboard/c.urdf", folder / "theirs", folder / "library")
    return folder / "library/cupboard_c"


def world(folder: Path, name: str) -> EnvWrapper:
    return EnvWrapper("door", folder, name, None, OPTIONS, render=False, vary_scale=False)


def usual(env: EnvWrapper, seed: int) -> np.ndarray:
    """Where the robot stands by the seed alone."""
    target, setup = env.env.target, sample_initial_state(seed, OPTIONS)
    handle = np.add(target.reference, nominal_root(env.env.asset, np.ones(3)))
    return base_pose(handle, target.side, setup, OPTIONS)


def test_where_the_arm_follows_the_door_the_robot_stands_where_it_always_does(tmp_path: Path) -> None:
    asset = make("bottom_cabinet", 0, 0, tmp_path)
    name = next(one.name for one in asset.joints if one.part_type == "door")
    env = world(tmp_path / asset.id, name)
    for seed in range(3):
        env.reset(seed)
        stands = env.env.agent.robot.pose.sp.to_transformation_matrix()
        assert np.abs(stands - usual(env, seed)).max() < 1e-5
    env.close()


def test_before_a_wide_door_it_stands_where_it_can_open_it(tmp_path: Path) -> None:
    folder = fridge(tmp_path, 0.8)
    assert list_unreachable(folder) == []
    env = world(folder, "hinge")
    recorder, moves = Recorder(env, DemonstrationsConfig()), []
    for seed in range(2):
        _, outcome = recorder.attempt(seed)
        assert outcome.success, outcome.cause
        x, y, z = (env.env.agent.robot.pose.sp.p - usual(env, seed)[:3, 3]).round(5).tolist()
        moves.append((x, -y, z))
    assert {(0, 0, 0), *((out, towards, 0) for out, towards in NEARBY)} >= set(moves)
    assert set(moves) != {(0, 0, 0)}
    env.close()


def test_a_door_is_tried_from_several_starts_of_the_skill(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, tried = fridge(tmp_path, 0.8), list[tuple[float, ...]]()

    def followed(*given: Any) -> list[str]:
        _, _, names, _, scale, _ = given
        tried.append(tuple(scale))
        return list(names) if len(tried) == 3 else []

    monkeypatch.setattr(reach, "_find_followed", followed)
    assert list_unreachable(folder) == []
    usual_scales = [tuple(sample_scale(seed, OPTIONS, OPTIONS.scale_range)) for seed in range(2)]
    assert tried == [(1, 1, 1), *usual_scales], "first at its own size, then as in episodes 0 and 1"


def test_a_wide_door_that_can_be_opened_no_further_than_is_enough_is_opened(tmp_path: Path) -> None:
    env = world(cupboard(tmp_path, 1.02), "hinge")
    env.place(0)
    where, around = env.env.base_from_asset(), env.env.sample_surroundings()
    goals = choose_open_goals(around.target, env.success_opening, MOTION.goal_margin)
    assert [can_follow(where, env.joints()[:7], around, goal) for goal in goals] == [False, False, True]
    outcome = OpenSkill(env, DemonstrationsConfig()).run(lambda action, noisy, ahead=FAR: env.act(action))
    assert outcome.success and env.success_opening < env.opened < 0.5
    env.close()


def test_a_door_that_is_followed_from_nowhere_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = fridge(tmp_path, 1.5)
    monkeypatch.setattr(reach, "STARTS", 1)  # seconds each
    assert list_unreachable(folder) == ["door 'hinge' is not opened: in none of 2 starts can the arm follow it"]
    env = world(folder, "hinge")
    env.reset(0)
    target = env.env.target
    base = base_pose(target.reference, target.side, find_middle_state(), OPTIONS)
    assert reachable_base(base, np.eye(4), REST, Surroundings(target), 0.5) is None
    stands = env.env.agent.robot.pose.sp.to_transformation_matrix()
    assert np.abs(stands - usual(env, 0)).max() < 1e-5, "then it stands where it always does"
    env.close()
