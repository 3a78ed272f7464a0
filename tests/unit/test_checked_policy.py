"""What a policy returns is looked at at its first step."""

from typing import Any

import numpy as np
import pytest

from roomkin.stages.policies.base import CheckedPolicy
from tests.refusals import refused


class Fixed:
    """A policy that gives what it is told to."""

    def __init__(self, actions: Any) -> None:
        self.actions = actions

    def start_episode(self, env_id: int, seed: int) -> None:
        pass

    def get_action(self, env_ids: Any, clouds: Any, proprio: Any) -> Any:
        return self.actions


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        (np.full((2, 7), np.nan), "no finite numbers"),
        (np.zeros(7), "shape (7,) for 2 environments"),
        (np.zeros((2, 8)), "shape (2, 8)"),
        (np.full((2, 7), -40.0), "the action -40"),
        ([["a"] * 7] * 2, "no finite numbers"),
    ],
)
def test_actions_that_are_none_are_told(actions: Any, words: str) -> None:
    with refused("E-POLICY-ACTIONS", "policy 'mine'", words):
        CheckedPolicy(Fixed(actions), "mine").get_action([0, 1], [], [])


def test_actions_are_handed_on() -> None:
    actions = np.linspace(-1, 1, 14).reshape(2, 7)
    assert np.array_equal(CheckedPolicy(Fixed(actions), "mine").get_action([0, 1], [], []), actions)
