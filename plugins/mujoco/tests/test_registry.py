"""The simulator is found by its name."""

from plugins.mujoco.environment import MujocoTaskEnv
from stages import plugins
from stages.config.model import load
from stages.tasks.api import EnvWrapper


def test_a_simulator_is_named_by_its_environments() -> None:
    assert plugins.load("simulators", "maniskill") is EnvWrapper
    assert plugins.load("simulators", "mujoco") is MujocoTaskEnv


def test_a_condition_that_names_no_simulator_has_that_of_the_section() -> None:
    config = load({"evaluation": {"simulator": "mujoco", "conditions": {"noise": {"depth_noise": True}}}})
    assert config.evaluation.under("noise").simulator == config.evaluation.simulator == "mujoco"
