"""A policy as a robot learner holds it: it takes observations as the environments give them."""

from pathlib import Path

import numpy as np
import pytest
import torch

from roomkin.plugins.api.loaded import LoadedPolicy, load_policy
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.policies.base import load_network, make_rollout_policy
from tests.refusals import refused
from tests.unit.trained_policy import trained


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return trained(tmp_path / "policy", PolicyConfig(points=40, horizon=3))


def observation(seed: int, *shape: int) -> dict[str, torch.Tensor]:
    random = torch.Generator().manual_seed(seed)
    cloud = torch.rand(*shape, 40, 4, generator=random)
    cloud[..., 3] = 0
    return {"point_cloud": cloud, "proprio": torch.rand(*shape, 9, generator=random)}


def acted(policy: LoadedPolicy, *shape: int) -> np.ndarray:
    return np.array([policy.act(observation(step, *shape)) for step in range(4)])


def test_it_acts_as_in_the_tests_and_remembers_until_reset(folder: Path) -> None:
    policy, acting = load_policy(folder), make_rollout_policy(load_network(folder, "best"), 1, "sharpened")
    assert (policy.env_id, policy.task_options.points) == ("ACDC-OpenDoor-v1", 512)
    acting.start_episode(0, 5)
    seen = [observation(step) for step in range(4)]
    known = [acting.get_action([0], [one["point_cloud"].numpy()], [one["proprio"].numpy()])[0] for one in seen]
    policy.reset(seed=5)
    assert np.array_equal(acted(policy), known)
    again = policy.act(seen[0])
    policy.reset(seed=5)
    assert np.array_equal(policy.act(seen[0]), known[0]) and not np.array_equal(again, known[0])


def test_the_batch_axis_counts_environments(folder: Path) -> None:
    policy = load_policy(folder, action="most_likely")
    assert acted(policy, 3).shape == (4, 3, 7)
    with refused("E-POLICY-OBSERVATION", "of 2 environments, the episode began with 3"):
        policy.act(observation(0, 2))
    policy.reset()
    one = acted(policy, 1)
    policy.reset()
    assert np.array_equal(one[:, 0], acted(policy))


@pytest.mark.parametrize("seen", [torch.zeros(1, 30), {"proprio": torch.zeros(1, 9)}])
def test_another_observation_is_refused(folder: Path, seen: object) -> None:
    with refused("E-POLICY-OBSERVATION", "point_cloud"):
        load_policy(folder).act(seen)  # type: ignore[arg-type]
