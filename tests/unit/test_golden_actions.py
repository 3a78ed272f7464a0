"""Every policy's actions on seeded observations, compared with those that are committed (as lerobot's golden files).

`python -m tests.unit.test_golden_actions` writes them anew: only where a change is meant to change what policies do.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.policies.base import make_policy, make_rollout_policy
from tests.packages import needs
from tests.unit.clouds import cabinet

GOLDEN = Path(__file__).with_name("golden_actions.json")
SMALL: dict[str, Any] = {"pointnet_width": 8, "rnn_hidden": 8, "mlp": [8]}
DENOISE: dict[str, Any] = {"pointnet_width": 8, "width": 16, "layers": 1, "n_action_steps": 2}
POLICIES = {
    "bc_rnn_gmm": PolicyConfig(points=64, horizon=3, kwargs=SMALL),
    "bc_rnn_gmm, handle": PolicyConfig(points=64, horizon=3, handle=True, kwargs=SMALL),
    "bc_rnn_gmm, no cloud": PolicyConfig(points=64, horizon=3, kwargs=SMALL | {"cloud": False}),
    "diffusion": PolicyConfig(
        policy="roomkin.plugins.diffusion.policies.diffusion", points=64, horizon=4, kwargs=DENOISE
    ),
    "diffusion, handle": PolicyConfig(
        policy="roomkin.plugins.diffusion.policies.diffusion", points=64, horizon=4, handle=True, kwargs=DENOISE
    ),
}


def act(config: PolicyConfig) -> list[list[float]]:
    """(4, 7) actions of a policy with random weights, fitted to a few clouds: the first two before a second episode."""
    torch.manual_seed(0)
    random = np.random.default_rng(0)
    clouds = torch.cat([cabinet(angle) for angle in (0.0, 0.1, 0.2, 0.3)])
    proprio = torch.from_numpy(random.normal(size=(4, 9)).astype(np.float32))
    actions = torch.from_numpy(random.uniform(-0.5, 0.5, (4, 7)).astype(np.float32))
    policy = make_policy(config).eval()
    policy.fit(clouds, proprio, actions, torch.arange(4))
    acting, done = make_rollout_policy(policy, 2, "sample"), []
    for seed, frames in ((5, (0, 1)), (6, (2, 3))):
        acting.start_episode(1, seed)
        done += [acting.get_action([1], [clouds[i].numpy()], [proprio[i].numpy()])[0] for i in frames]
    return [[round(float(number), 5) for number in row] for row in done]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=needs("diffusion")) if "diffusion" in name else name for name in POLICIES]
)
def test_actions_are_those_of_before(name: str) -> None:
    assert np.allclose(act(POLICIES[name]), json.loads(GOLDEN.read_text())[name], atol=1e-4)


def write() -> None:
    """Write the actions of today."""
    rows = {name: act(config) for name, config in POLICIES.items()}
    text = ",\n".join(f' "{name}": {json.dumps(actions)}' for name, actions in rows.items())
    GOLDEN.write_text("{\n" + text + "\n}\n")


if __name__ == "__main__":
    write()
