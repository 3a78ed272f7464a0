"""Attempts that are disturbed, and what is recorded of them; physics alone, no renderer."""

import numpy as np
import pytest

from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.demonstrations.attempt import Recorder, sample_disturbance
from roomkin.stages.skills import FAR
from roomkin.stages.skills.motion import CLOSED
from roomkin.stages.skills.open import OpenSkill
from roomkin.stages.tasks.api import EnvWrapper
from tests.unit.demo_assets import cabinet


@pytest.fixture(scope="module")
def door(tmp_path_factory: pytest.TempPathFactory) -> EnvWrapper:
    folder = tmp_path_factory.mktemp("assets") / "door"
    cabinet(folder)
    return EnvWrapper("door", folder, "door_0_joint", None, TaskConfig(scale_variants=1), render=False)


def test_what_is_recorded_is_the_clean_action_and_what_is_executed_is_not(
    door: EnvWrapper, monkeypatch: pytest.MonkeyPatch
) -> None:
    """DART: the policy is to learn what was meant, from states that the noise led to."""
    executed: list[np.ndarray] = []
    act = door.act
    monkeypatch.setattr(door, "act", lambda action: (executed.append(np.array(action)), act(action)))

    def attempted(noise: float) -> tuple[np.ndarray, np.ndarray]:
        executed.clear()
        episode, outcome = Recorder(door, DemonstrationsConfig(noise=noise, recovery=0.0)).attempt(5)
        assert outcome.success
        return np.array(episode.actions), np.array(executed)

    clean, same = attempted(0.0)
    recorded, noisy = attempted(0.005)
    assert np.array_equal(clean, same)
    assert np.array_equal(recorded[0], clean[0])  # the same state asks for the same action, whatever is then executed
    gap = noisy - recorded
    moving = np.abs(gap[:, :3]).max(axis=1) > 0
    assert moving[0] and moving.sum() > 10 and not gap[:, 3:].any()
    assert 0.06 < gap[moving, :3].std() < 0.14  # 5 mm of steps of 5 cm
    assert np.abs(recorded[:, :3]).max() <= 1.0 + 1e-6
    assert not moving[-2:].any()  # it lets go without noise


def test_a_missed_handle_is_tried_again(door: EnvWrapper) -> None:
    """The gripper is shut on the way: the skill notices, backs off with open fingers, and comes again."""
    door.place(2)
    moved = 0

    def act(action: np.ndarray, noisy: bool, ahead: float = FAR) -> None:
        nonlocal moved
        moved += 1
        door.act(np.array([*np.zeros(6), -1.0], np.float32) if 5 <= moved < 9 else action)

    outcome = OpenSkill(door, DemonstrationsConfig(noise=0.0)).run(act)
    assert outcome.success and outcome.retries == 1 and moved < door.max_steps


@pytest.mark.parametrize(("kind", "seed"), [("push", 7), ("miss", 3)])
def test_a_disturbed_attempt_shows_what_to_do_and_not_what_went_wrong(door: EnvWrapper, kind: str, seed: int) -> None:
    episode, outcome = Recorder(door, DemonstrationsConfig(noise=0.0, recovery=1.0)).attempt(seed)
    assert outcome.success and episode.recovery == kind
    meant, executed = np.array(episode.actions), np.array(episode.executed)
    wrong = (meant != executed).any(axis=1)
    assert 2 <= wrong.sum() <= 9
    first, last = np.flatnonzero(wrong)[[0, -1]]
    assert last - first < 9 and last < len(meant) - 6  # a burst, before the grasp
    fingers = np.array(episode.proprios)[:, 7:].max(axis=1)
    if kind == "push":
        assert outcome.retries == 0
        return
    assert outcome.retries >= 1 and fingers[last + 1] < 0.001  # shut on nothing
    shut = np.flatnonzero(fingers[: last + 2] < 0.02)
    assert (meant[shut, 6] > 0).all(), "shut too early, the skill wants them open"
    assert meant[shut, 0].min() < -0.2, "and backs off"


def test_some_attempts_are_disturbed_by_their_seed() -> None:
    drawn = [sample_disturbance(np.random.default_rng((seed, 2)), 0.4) for seed in range(400)]
    kinds = [item.kind if item else None for item in drawn]
    assert 40 < kinds.count("push") < 120 and 40 < kinds.count("miss") < 120


def test_a_hand_that_missed_is_pulled_back_and_never_pushed_on_into_the_front() -> None:
    drawn = [sample_disturbance(np.random.default_rng((seed, 2)), 1.0) for seed in range(200)]
    for item in drawn:
        assert item is not None
        moving = item.actions[np.abs(item.actions[:, :3]).max(axis=1) > 0]
        assert np.linalg.norm(moving[:, :3], axis=1).max(initial=0) < 1
        shut = moving[moving[:, 6] == CLOSED]
        assert item.kind == "miss" or not len(shut)
        assert (shut[:, 0] < -0.1).all()
    pulled = [item for item in drawn if item and item.actions[-1, 6] == CLOSED and item.actions[-1, :3].any()]
    assert len(pulled) > 50
