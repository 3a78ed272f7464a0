"""Which of many ways a skill takes: joints to spare, by the rest pose, from above; where a hand can be held at all."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.planning import rollout
from roomkin.stages.planning.articulation import (
    FROM_ABOVE,
    Grasp,
    choose_open_goals,
    choose_release_opening,
    grasp_pose,
    list_approaches,
    list_grasps,
    list_last_resorts,
)
from roomkin.stages.planning.clearance import Surroundings, make_line, measure_distance
from roomkin.stages.planning.rollout import Stretch, find_feasible, roll_out
from roomkin.stages.simulation.kinematics import Chain, track
from roomkin.stages.simulation.robot import REST
from roomkin.stages.skills import FAR, Outcome
from roomkin.stages.skills.motion import OPEN_STEPS, Motion
from roomkin.stages.skills.open import OpenSkill
from roomkin.stages.tasks.api import EnvWrapper
from tests.unit.demo_assets import cabinet

OPTIONS = TaskConfig(scale_variants=1)


@pytest.fixture(scope="module")
def door(tmp_path_factory: pytest.TempPathFactory) -> EnvWrapper:
    folder = tmp_path_factory.mktemp("assets") / "door"
    cabinet(folder)
    return EnvWrapper("door", folder, "door_0_joint", None, OPTIONS, render=False)


def test_of_ways_that_can_be_followed_the_first_with_joints_to_spare_is_taken(
    door: EnvWrapper, monkeypatch: pytest.MonkeyPatch
) -> None:
    door.place(0)
    chain, where = door.chain, door.env.base_from_asset()
    hand = chain.pose(REST[None])[0]
    goals = [
        [0.03, 0.0, -0.03],
        [-0.18, 0.0, 0.0],
        [-0.05, 0.0, 0.0],
    ]  # metres from rest, where joint 4 is 0.46 from its limit
    ways = [
        [Stretch(make_line(hand, hand + np.pad([[x] for x in goal], ((0, 1), (3, 0)))), 0.04, (0.0, 0.0))]
        for goal in goals
    ]
    ends = [chain.margin(joints_at_end(chain, way[0].path)[None]).min() for way in ways]
    assert ends[0] > 0.4 and ends[1] < 0.2 < ends[2] < ends[0]

    class Free(Surroundings):
        def clear(self, centers: np.ndarray, radii: np.ndarray, values: np.ndarray) -> bool:
            return True

    def taken(order: list[int], spare: float) -> int | None:
        return find_feasible(chain, REST, [ways[i] for i in order], where, Free(door.env.target), spare)

    assert taken([1, 2, 0], 0.0) == 0
    assert taken([1, 2, 0], 0.2) == 1, "not the one with most, the first with enough"
    assert taken([1, 0, 2], 1.0) == 1, "none has enough: the one with most"
    rolled_out = [taken([1, 2, 0], spare) for spare in (0.0, 0.2, 1.0)]
    counts = []

    def counted(chain: Chain, joints: np.ndarray, paths: list[np.ndarray], slack: list[np.ndarray]) -> Any:
        counts.append(len(paths))
        return roll_out(chain, joints, paths, slack)

    monkeypatch.setattr(rollout, "BATCH", (1, 1))
    monkeypatch.setattr(rollout, "roll_out", counted)
    assert [taken([1, 2, 0], spare) for spare in (0.0, 0.2, 1.0)] == rolled_out
    assert counts == [1] * (1 + 2 + 3), "no more are rolled out than are looked at"


def test_the_joint_moves_evenly_along_a_stretch(door: EnvWrapper) -> None:
    door.place(0)
    seen: list[np.ndarray] = []

    class Recorder(Surroundings):
        def clear(self, centers: np.ndarray, radii: np.ndarray, values: np.ndarray) -> bool:
            seen.append(values)
            return True

    hand = door.chain.pose(REST[None])[0]
    line = make_line(hand, hand + np.pad([[-0.08], [0.0], [0.0]], ((0, 1), (3, 0))))
    way = [Stretch(line, 0.04, (0.2, 0.8))]
    assert find_feasible(door.chain, REST, [way], door.env.base_from_asset(), Recorder(door.env.target)) == 0
    (values,) = seen
    assert len(values) > 2 and values == pytest.approx(np.linspace(0.2, 0.8, len(values) + 1)[1:])


def joints_at_end(chain: Chain, path: np.ndarray) -> np.ndarray:
    """(7,) joints of an arm that followed a path of the hand from rest."""
    joints = REST
    for pose in path:
        joints = track(chain, joints[None], pose[None])[0]
    return np.asarray(joints)


def test_an_arm_that_is_elsewhere_may_go_through_rest(door: EnvWrapper) -> None:
    chain = door.chain
    rest = chain.pose(REST[None])[0]
    before = rest.copy()
    before[:3, 3] += [0.1, 0.0, -0.1]
    elsewhere = REST + np.array([0.8, 0.4, -0.3, 0.5, 0.4, -0.6, 0.5])
    assert [slack for _, slack in list_approaches(chain, REST, before, 0.1)] == [1.0, 1.0]  # straight, and from above
    way, slack = [*list_approaches(chain, elsewhere, before, 0.1)][-1]
    assert slack > 1.0
    assert way[0] == pytest.approx(chain.pose(elsewhere[None])[0]) and way[-1] == pytest.approx(before)
    gaps = measure_distance(way, np.broadcast_to(rest, way.shape))
    assert gaps.min() < 1e-6, "the hand is at rest"
    assert measure_distance(way[1:], way[:-1]).max() < 0.06
    joints = elsewhere
    for pose in way[: gaps.argmin() + 1]:
        joints = track(chain, joints[None], pose[None])[0]
    assert chain.margin(joints[None]).min() > 0.3, "the arm comes there with no joint at a limit"


def test_a_bar_is_held_from_above_only_on_a_drawer_and_last(door: EnvWrapper, tmp_path: Path) -> None:
    cabinet(tmp_path / "drawer", layout=[["drawer", "open"]])
    drawer = EnvWrapper("drawer", tmp_path / "drawer", "drawer_0_joint", None, OPTIONS, render=False)
    door.place(0)
    drawer.place(0)
    for task, last in ((door, []), (drawer, list(FROM_ABOVE))):
        handle = task.env.target.handle
        assert handle is not None
        ways = list(list_grasps(task.env.target, handle))
        assert [(way.tilt, way.pitch) for way in ways if way.pitch] == last
        assert [(way.tilt, way.pitch) for way in ways[len(ways) - len(last) :]] == last
    over = grasp_pose(handle, Grasp(0.0, 0.5, 1.0, 0.0), np.eye(4))
    assert over[:3, 2] == pytest.approx([-np.cos(0.5), 0.0, -np.sin(0.5)])
    drawer.close()


def test_a_door_of_a_wide_range_need_not_be_moved_much_further_than_is_enough(door: EnvWrapper) -> None:
    door.place(0)
    for degrees, opening, goals, let_go in (
        (90, 0.5, [63.0, 55.8, 50.4], [54.0, 54.0, 48.6]),
        (180, 1 / 3, [96.0, 81.6, 70.8], [78.0, 78.0, 67.2]),
    ):
        target = replace(door.env.target, lower=0.1, upper=0.1 + np.deg2rad(degrees))
        values = choose_open_goals(target, opening, 0.2)
        assert np.rad2deg(np.subtract(values, 0.1)) == pytest.approx(goals)
        assert [degrees * choose_release_opening(target, opening, 0.2, value) for value in values] == pytest.approx(
            let_go
        )
        assert all(opening * degrees < some < goal for some, goal in zip(let_go, goals, strict=True))


def test_a_grasp_that_missed_twice_gives_way_to_another(door: EnvWrapper, monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[Grasp] = []

    def miss(self: OpenSkill, motion: Motion, plan: Any) -> str:
        taken.append(plan.grasp)
        return "converge"

    monkeypatch.setattr(OpenSkill, "_approach", miss)
    skill = OpenSkill(door, DemonstrationsConfig())
    motion = Motion(door, lambda action, noisy, ahead=0.0: None)
    door.place(0)
    for number in (0, 1, 2, 3, 4, 0):
        assert skill.attempt(motion, number) == "converge"
    first, again, other, other_again, third, anew = taken
    assert first == again == anew and other == other_again
    assert len({first, other, third}) == 3
    every = list(list_grasps(door.env.target, door.env.target.handle))  # type: ignore[arg-type]
    skill.missed += 2 * [(grasp, "converge") for grasp in every]
    assert skill.attempt(motion, 1) == "converge" and taken[-1] in every, "where none is left any will do"


def test_a_door_that_is_open_is_let_go_while_there_is_time(door: EnvWrapper, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[float] = []

    def act(action: np.ndarray, noisy: bool, ahead: float = FAR) -> None:
        door.act(action)
        opened.append(door.opened)

    def attempt() -> Outcome:
        opened.clear()
        door.place(1)
        return OpenSkill(door, DemonstrationsConfig()).run(act)

    assert attempt().success
    first = 1 + next(step for step, value in enumerate(opened) if value >= door.success_opening)
    assert first + OPEN_STEPS < len(opened), "it is opened further while there is time for that"
    monkeypatch.setattr(door, "max_steps", first + OPEN_STEPS)
    assert attempt() == Outcome(True, "success") and len(opened) == door.max_steps


def test_where_no_other_grasp_opens_a_door_a_level_bar_is_held_from_above(door: EnvWrapper) -> None:
    door.place(0)
    target = door.env.target
    assert target.handle is not None
    level = replace(target.handle, axis=np.array([0.0, 1.0, 0.0]), length=0.2, width=0.01)
    above = list(list_last_resorts(target, level))
    assert all(grasp.pitch > 0 and not grasp.swing for grasp in above) and {g.follow for g in above} == {0.0, 0.5, 1.0}
    assert not set(above) & set(list_grasps(target, level))
    assert all(grasp_pose(level, grasp, np.eye(4))[2, 2] < -0.2 for grasp in above), "it comes down to the bar"
    from_the_hinge = list(list_last_resorts(target, target.handle))
    assert from_the_hinge and all(grasp.swing * target.side < 0 and not grasp.pitch for grasp in from_the_hinge)
    assert not list(list_last_resorts(replace(target, revolute=False), level)), "a drawer has its own"
