"""The tasks in the simulator and the skill that opens them; physics alone, no renderer."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.handle import Handle
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import invert_transform, make_transform, yaw_matrix
from roomkin.stages.planning.articulation import Grasp, grasp_pose, plan_articulation
from roomkin.stages.planning.clearance import Pursuit, Surroundings, make_handle_path, make_line, measure_distance
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.skills import FAR, Act, Outcome
from roomkin.stages.skills.close import CloseSkill
from roomkin.stages.skills.motion import Motion
from roomkin.stages.skills.open import OpenSkill
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.base_placement import _passes
from tests.refusals import refused
from tests.unit.demo_assets import cabinet

OPTIONS = TaskConfig(scale_variants=1)


@pytest.fixture(scope="module")
def door(tmp_path_factory: pytest.TempPathFactory) -> EnvWrapper:
    folder = tmp_path_factory.mktemp("assets") / "door"
    cabinet(folder)
    return EnvWrapper("door", folder, "door_0_joint", None, OPTIONS, render=False)


def act_of(task: EnvWrapper) -> Act:
    return lambda action, noisy, ahead=FAR: task.act(action)


def attempt(task: EnvWrapper, seed: int) -> Outcome:
    task.place(seed)
    return OpenSkill(task, DemonstrationsConfig(noise=0.0)).run(act_of(task))


def test_an_unknown_task_or_joint_is_one_clear_line(tmp_path: Path) -> None:
    cabinet(tmp_path / "door")
    with refused("E-TASK-JOINT"):
        EnvWrapper("door", tmp_path / "door", "nonsense", None, OPTIONS)
    with pytest.raises(InputError, match=r"no 'drower'.* did you mean 'drawer'"):
        EnvWrapper("drower", tmp_path / "door", "door_0_joint", None, OPTIONS)


def test_a_seed_gives_one_initial_state(door: EnvWrapper) -> None:
    first = door.reset(7)["proprio"]
    other = door.reset(8)["proprio"]
    again = door.reset(7)["proprio"]
    assert np.array_equal(first, again) and not np.array_equal(first, other)
    assert door.opened == 0.0 and not door.success


@pytest.mark.parametrize("controller", ["pd_ee_dls", "pd_ee_target_delta_pose"])
def test_an_action_moves_the_hand_in_the_base_frame(tmp_path: Path, controller: str) -> None:
    cabinet(tmp_path / "door")
    options = OPTIONS.model_copy(update={"controller": controller})
    task = EnvWrapper("door", tmp_path / "door", "door_0_joint", None, options, render=False)
    task.place(3)
    before = task.hand()
    for _ in range(3):
        task.act(np.array([-0.4, 0.4, 0, 0, 0, 0.5, 1], np.float32))
    for _ in range(2):
        result = task.step(np.array([0, 0, 0, 0, 0, 0, -1], np.float32))
    moved = task.hand()
    assert 0.03 < moved[1, 3] - before[1, 3] < 0.065 and 0.03 < before[0, 3] - moved[0, 3] < 0.065
    turn = moved[:3, :3] @ before[:3, :3].T
    assert 0.15 < np.arctan2(turn[1, 0], turn[0, 0]) < 0.35
    assert task.joints()[7:].max() < 0.03  # the fingers close
    assert not result.done and result.observation["point_cloud"].shape == (options.points, 4)
    task.close()


def test_an_episode_is_over_after_its_last_step(door: EnvWrapper) -> None:
    door.place(0)
    for steps, over in ((door.max_steps - 1, False), (door.max_steps, True)):
        door.steps = steps - 1
        assert door.step(np.array([0, 0, 0, 0, 0, 0, 1], np.float32)).done is over


@pytest.mark.parametrize(
    ("options", "enough"),
    [({}, 45.0), ({"success_angle": 30.0}, 30.0), ({"success_fraction": 0.9}, 60.0)],
    ids=["half", "angle", "sixty"],
)
def test_a_door_is_open_at_half_of_its_range_or_at_an_angle(
    door: EnvWrapper, monkeypatch: pytest.MonkeyPatch, options: dict[str, float], enough: float
) -> None:
    door.place(0)
    monkeypatch.setattr(door.env, "options", OPTIONS.model_copy(update=options))
    assert door.success_opening * 90 == pytest.approx(enough, abs=1e-3)
    for degrees, expected in ((enough - 1, False), (enough + 1, True)):
        door.env.object.set_qpos(np.array([[np.deg2rad(degrees)]], np.float32))
        assert bool(door.env.evaluate()["success"][0]) is expected


def test_a_drawer_is_open_at_half_of_its_range_or_at_a_length(tmp_path: Path) -> None:
    cabinet(tmp_path / "drawer", layout=[["drawer", "open"]])
    options = OPTIONS.model_copy(update={"success_distance": 0.05})
    drawer = EnvWrapper("drawer", tmp_path / "drawer", "drawer_0_joint", None, options, render=False)
    drawer.place(0)
    length = drawer.env.target.upper - drawer.env.target.lower
    assert drawer.success_opening * length == pytest.approx(0.05)
    drawer.close()


def test_the_official_criterion_is_any_joint_at_any_time(tmp_path: Path) -> None:
    cabinet(tmp_path / "two", layout=[["door", "door"]])
    task = EnvWrapper("door", tmp_path / "two", "door_0_joint", None, OPTIONS, render=False)
    task.place(0)
    stay = np.array([0, 0, 0, 0, 0, 0, 1], np.float32)
    for value, expected in ((0.05, False), (0.2, True), (0.0, True)):
        qpos = np.zeros((1, 2), np.float32)
        qpos[0, 1 - task.env.target.index] = value * np.pi / 2
        task.env.object.set_qpos(qpos)
        task.act(stay)
        assert task.official_success is expected and not task.success
    task.place(1)
    task.act(stay)
    assert not task.official_success
    task.close()


def test_the_cloud_shows_the_target_or_the_object(tmp_path: Path) -> None:
    cabinet(tmp_path / "two", layout=[["door", "door"]])
    task = EnvWrapper("door", tmp_path / "two", "door_0_joint", None, OPTIONS, render=False)
    task.place(0)
    links = {link.entity.per_scene_id: link.name for link in task.env.object._objs[0].links}
    assert all("door_0" in links[i] for i in task.env.seen_ids().tolist())
    task.env.options = OPTIONS.model_copy(update={"cloud": "object"})
    assert set(task.env.seen_ids().tolist()) == set(links)
    task.close()


def test_a_straight_path_keeps_its_ends_and_spacing() -> None:
    start, end = np.eye(4), make_transform(yaw_matrix(1.0), [0.1, 0.0, 0.0])
    path = make_line(start, end)
    assert path[0] == pytest.approx(start) and path[-1] == pytest.approx(end)
    assert measure_distance(path[1:], path[:-1]).max() < 0.006


def test_pursuit_aims_ahead_and_never_back() -> None:
    path = make_line(np.eye(4), make_transform(np.eye(3), [1.0, 0.0, 0.0]))
    pursuit = Pursuit(path, lookahead=0.1)
    assert pursuit.aim(make_transform(np.eye(3), [0.05, 0.02, 0.0]))[0, 3] == pytest.approx(0.15, abs=0.01)
    assert pursuit.aim(make_transform(np.eye(3), [0.0, 0.0, 0.0]))[0, 3] >= 0.14
    assert pursuit.progress == pytest.approx(0.05, abs=0.006)


@pytest.mark.parametrize(("speed", "word"), [(0.004, ""), (0.0, "stall")])
def test_a_hand_that_is_slow_has_not_stalled_and_one_that_is_stuck_has(speed: float, word: str) -> None:
    path, hand = make_line(np.eye(4), make_transform(np.eye(3), [0.1, 0.0, 0.0])), np.eye(4)

    def act(action: Array, moving: bool, ahead: float) -> None:
        hand[0, 3] += speed  # metres a step

    task = SimpleNamespace(options=TaskConfig(), steps=0, max_steps=100, hand=hand.copy, reference=hand.copy)
    assert Motion(task, act).reach(path, 0.02, 1.0)[0] == word  # type: ignore[arg-type]


def test_the_opening_path_turns_about_the_hinge(door: EnvWrapper) -> None:
    door.place(0)
    target = door.env.target
    assert target.handle is not None
    grasp = grasp_pose(target.handle, Grasp(0.0, 0.0, 1.0), np.eye(4))
    path = make_handle_path(target, grasp, target.lower, target.lower + np.pi / 3, follow=1.0)
    radii = np.linalg.norm(path[:, :2, 3] - target.origin[:2], axis=1)
    assert np.ptp(radii) < 1e-6
    assert path[-1, 0, 3] > grasp[0, 3] + 0.2  # outwards
    assert path[-1][:3, :3] @ path[0][:3, :3].T == pytest.approx(yaw_matrix(np.pi / 3 * target.axis[2]), abs=1e-6)


def test_a_horizontal_bar_is_held_one_way_whichever_way_the_hand_is_turned(door: EnvWrapper) -> None:
    """Both ways are a right angle from the hand: noise would choose, and demonstrations would show two motions."""
    door.place(0)
    handle = door.env.target.handle
    assert handle is not None
    for axis, along in (([0.0, 1.0, 0.0], 2), ([0.0, -1.0, 0.0], 2), ([0.0, 0.0, 1.0], 1)):
        bar = replace(handle, axis=np.array(axis), length=0.2, width=0.01)
        hands = [
            make_transform(yaw_matrix(np.pi) @ Rotation.from_euler("x", turn).as_matrix(), np.zeros(3))
            for turn in (-1, 1)
        ]
        closing = [grasp_pose(bar, Grasp(0.0, 0.0, 1.0), hand)[along, 1] for hand in hands]
        assert closing == pytest.approx([1.0, 1.0] if along == 2 else [-1.0, -1.0])


def test_clearance_sees_the_panel_where_it_is(door: EnvWrapper) -> None:
    door.place(0)
    target = door.env.target
    around = Surroundings(target)
    before_the_front = np.array([[[target.moving.bounds[1, 0] + 0.1, 0.0, 0.35]]])
    radii, closed = np.array([0.03]), np.array([target.lower])
    assert around.clear(before_the_front, radii, closed)
    assert not around.clear(np.array([[[target.origin[0] - 0.01, 0.0, 0.35]]]), radii, closed)
    swinging = np.linspace(0.1, 1.0, 10)
    assert not around.clear(np.repeat(before_the_front, 10, axis=0), radii, swinging)  # it swings by
    assert not around.with_obstacles(before_the_front[0] + 0.02).clear(before_the_front, radii, closed)
    assert around.clear(before_the_front, radii, closed)  # the other one is a copy


def test_no_base_is_where_the_door_swings(door: EnvWrapper) -> None:
    door.place(0)
    target = door.env.target
    _, y, _ = target.reference
    for out, goal, free in ((0.3, 1.5, False), (0.3, 0.1, True), (1.0, 1.5, True)):
        base = make_transform(np.eye(3), [target.moving.bounds[1, 0] + out, y, target.moving.bounds[0, 2]])
        assert _passes(invert_transform(base), Surroundings(target), goal) is free


def test_clearance_sees_a_finger_inside_a_knob(door: EnvWrapper) -> None:
    door.place(0)
    knob = trimesh.creation.icosphere(radius=0.02)
    knob.apply_translation([1.0, 0.0, 0.0])
    around = Surroundings(replace(door.env.target, fixed=trimesh.util.concatenate([door.env.target.fixed, knob])))
    closed = np.array([door.env.target.lower])
    for x, clear in ((1.0, False), (1.012, False), (1.05, True)):
        assert around.clear(np.array([[[x, 0.0, 0.0]]]), np.array([0.0075]), closed) is clear


def test_a_thick_bar_is_held_at_its_middle(door: EnvWrapper) -> None:
    door.place(0)
    handle = door.env.target.handle
    assert handle is not None
    for width, depth in ((0.012, 0.009), (0.044, 0.022), (0.06, 0.03)):
        bar = replace(handle, axis=np.array([0.0, 0.0, 1.0]), length=0.3, width=width, protrusion=0.09)
        held = grasp_pose(bar, Grasp(0.0, 0.0, 1.0), np.eye(4))
        assert bar.position[0] - held[0, 3] == pytest.approx(depth)
        if width < 0.018:
            by_its_tips = grasp_pose(bar, Grasp(0.0, 0.0, 1.0, 0.0), np.eye(4))
            assert by_its_tips[0, 3] == pytest.approx(bar.position[0])


def test_doors_and_drawers_are_opened(door: EnvWrapper, tmp_path: Path) -> None:
    outcomes = [attempt(door, seed) for seed in range(4)]
    assert [outcome.cause for outcome in outcomes] == ["success"] * 4
    assert door.opened > 0.5 and 15 < door.steps < 60
    cabinet(tmp_path / "drawer", layout=[["drawer", "open"]], handle="knob", protrusion=0.034)
    drawer = EnvWrapper("drawer", tmp_path / "drawer", "drawer_0_joint", None, OPTIONS, render=False)
    assert sum(attempt(drawer, seed).success for seed in range(4)) >= 3
    drawer.close()


def test_what_was_opened_is_closed_again(door: EnvWrapper) -> None:
    assert attempt(door, 1).success
    opened = door.opened
    motion = Motion(door, act_of(door))
    assert motion.retreat(0.1) == ""
    outcome = CloseSkill(door, DemonstrationsConfig(noise=0.0)).run(act_of(door))
    assert outcome == Outcome(True, "success") and opened > 0.5 and door.opened < 0.05


def test_failures_have_causes(tmp_path: Path) -> None:
    cabinet(tmp_path / "smooth", handle="none")
    smooth = EnvWrapper("door", tmp_path / "smooth", "door_0_joint", None, OPTIONS, render=False)
    assert attempt(smooth, 0) == Outcome(False, "no_handle")
    smooth.close()
    cabinet(tmp_path / "door")
    far = EnvWrapper(
        "door", tmp_path / "door", "door_0_joint", None, OPTIONS.model_copy(update={"base_distance": 1.6}), render=False
    )
    assert attempt(far, 0) == Outcome(False, "no_plan")
    far.close()


def test_no_plan_goes_through_an_obstacle(door: EnvWrapper) -> None:
    door.place(0)
    target = door.env.target

    class Blocked(Surroundings):
        def clear(self, centers: np.ndarray, radii: np.ndarray, values: np.ndarray) -> bool:
            return False

    arguments = (door.chain, door.joints()[:7], door.env.base_from_asset())
    goal = (target.lower, target.lower + 0.9, DemonstrationsConfig())
    assert plan_articulation(*arguments, Surroundings(target), *goal) is not None
    assert plan_articulation(*arguments, Blocked(target), *goal) is None


def test_the_tasks_are_known_to_gym_and_end_at_their_own_horizon(tmp_path: Path) -> None:
    import roomkin.stages.tasks  # noqa: F401

    cabinet(tmp_path / "door")
    options = TaskConfig(max_steps=12)
    env = gymnasium.make(
        "ACDC-OpenDoor-v1",
        asset_folder=tmp_path / "door",
        joint="door_0_joint",
        options=options,
        obs_mode="none",
        reward_mode="none",
        sim_backend=options.sim_backend,
        render_backend="none",
    )
    env.reset(seed=0)
    steps = [bool(env.step(env.action_space.sample() * 0)[3].all()) for _ in range(12)]
    assert steps == [False] * 11 + [True]
    env.close()
    assert "ACDC-OpenDrawer-v1" in gymnasium.registry
    with refused("E-DEVICE-GPU"):
        EnvWrapper("door", tmp_path / "door", "door_0_joint", None, TaskConfig(sim_backend="physx_cuda"))


def test_a_heavy_flap_is_opened_from_beside_it(tmp_path: Path) -> None:
    cabinet(tmp_path / "oven", layout=[["panel"], ["flap"]], major="rows", handle_length=0.6, density=1500.0)
    flap = EnvWrapper("door", tmp_path / "oven", "door_0_joint", None, OPTIONS, render=False)
    assert sum(attempt(flap, seed).success for seed in range(3)) >= 2
    beside = invert_transform(flap.env.base_from_asset())[:3, 3] - flap.env.target.reference
    assert flap.env.target.flap and abs(beside[1]) > 0.2
    flap.close()


@pytest.mark.parametrize(("fingers", "held"), [(0.0005, False), (0.006, True), (0.034, True), (0.04, False)])
def test_what_is_between_the_fingers_may_be_thin_or_wide(
    door: EnvWrapper, monkeypatch: pytest.MonkeyPatch, fingers: float, held: bool
) -> None:
    monkeypatch.setattr(door, "joints", lambda: np.append(np.zeros(7), [fingers, fingers]))
    assert Motion(door, act_of(door)).holds is held


def test_a_knob_beside_another_is_held_from_above_and_below() -> None:
    handle = Handle(np.array([0.3, 0.02, 0.5]), np.array([0.0, 1.0, 0.0]), 0.03, 0.03, 0.03)
    sideways, over = (grasp_pose(handle, Grasp(0.0, 0.0, 1.0, over=over), np.eye(4)) for over in (False, True))
    assert np.abs(sideways[:3, 1]) == pytest.approx([0, 1, 0]), "the fingers close along y"
    assert np.abs(over[:3, 1]) == pytest.approx([0, 0, 1])
    assert over[:3, 2] == pytest.approx([-1, 0, 0]), "straight in"
    assert np.linalg.det(over[:3, :3]) == pytest.approx(1.0)
