"""A policy that leaves the house: the same actions from torch and safetensors alone."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from roomkin.plugins.exports.bc_rnn_gmm.loader import PortablePolicy
from roomkin.plugins.exports.policy import run
from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
from roomkin.stages.policies.base import load_network, make_rollout_policy, save_weights
from roomkin.stages.policies.handle_points import segment_handles
from tests.refusals import refused
from tests.unit.trained_policy import trained

STRANGER = """
import sys
sys.modules["roomkin"] = None  # installed here, but not where the policy goes
folder, *exported = sys.argv[1:]
sys.path.insert(0, exported[0])
import torch
from loader import PortablePolicy
from safetensors.torch import load_file
seen = load_file(folder + "/seen.safetensors")
policies = [PortablePolicy(out) for out in exported]
print([[policy(*now).tolist() for now in zip(seen["clouds"], seen["proprio"])] for policy in policies])
"""
RUNS = (
    PolicyConfig(points=40, horizon=3),
    PolicyConfig(
        points=40,
        kwargs={"cloud_frame": "robot", "pointnet_layers": 3, "mlp": [32, 16], "gmm_modes": 3},
        horizon=3,
    ),
    PolicyConfig(points=40, kwargs={"mlp": []}, horizon=3),
    PolicyConfig(points=40, horizon=3, handle=True),
)


def test_the_loader_acts_as_our_actor(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    clouds, proprio = random.normal(size=(5, 40, 4)).astype(np.float32), random.normal(size=(5, 9)).astype(np.float32)
    clouds[..., 3] = clouds[..., 3] > 0
    clouds[:, :30, 0] = 0.5  # a front; some of the rest stand before it
    clouds[:, 30:, 0] = np.linspace(0.46, 0.5, 10)
    assert (segment_handles(torch.tensor(clouds))[0][..., 3] == -1).any()
    save_weights(tmp_path / "seen.safetensors", {"clouds": torch.tensor(clouds), "proprio": torch.tensor(proprio)})
    exported, ours = [], []
    for number, setting in enumerate(RUNS):
        folder = trained(tmp_path / f"policy_{number}", setting)
        exported.append(tmp_path / f"out_{number}")
        run(policy=folder, out=exported[-1], action="most_likely")
        acting = make_rollout_policy(load_network(folder, "best"), 1, "most_likely")
        acting.start_episode(0, 0)
        ours.append([acting.get_action([0], [cloud], [own])[0] for cloud, own in zip(clouds, proprio, strict=True)])
    words = [sys.executable, "-I", "-c", STRANGER, *map(str, [tmp_path, *exported])]
    done = subprocess.run(words, capture_output=True, text=True, cwd="/", check=False)
    assert done.returncode == 0, done.stderr
    assert np.array(json.loads(done.stdout)) == pytest.approx(np.array(ours), abs=1e-5)
    assert np.ptp(ours, axis=1).min() > 1e-4, "actions that change say more"


def test_modes_are_drawn_by_the_square_of_their_weight_unless_told_otherwise(tmp_path: Path) -> None:
    folder = trained(tmp_path / "policy", PolicyConfig(points=40, kwargs={"gmm_modes": 2}))
    cloud, proprio = torch.rand(40, 4).round(decimals=1), torch.zeros(9)
    with torch.no_grad():
        mixture = load_network(folder, "best")(cloud[None, None], proprio[None, None])  # type: ignore[operator]
    torch.manual_seed(0)
    for action, power in (("sharpened", 2.0), ("sample", 1.0)):
        run(policy=folder, out=tmp_path / action, **({} if power == 2.0 else {"action": action}))  # type: ignore[arg-type]
        policy = PortablePolicy(str(tmp_path / action))
        drawn = []
        for _ in range(400):
            policy.past.clear()
            drawn.append(torch.allclose(policy(cloud, proprio), mixture.means[0, 0, 0], atol=1e-4))
        assert np.mean(drawn) == pytest.approx(float((power * mixture.logits[0, 0]).softmax(0)[0]), abs=0.06)


def test_the_loader_is_short_and_names_what_it_reads(tmp_path: Path) -> None:
    run(policy=trained(tmp_path / "policy", PolicyConfig()), out=tmp_path / "out")
    loader = (tmp_path / "out" / "loader.py").read_text()
    assert len(loader.splitlines()) <= 45 and "roomkin" not in loader
    assert "roomkin" not in (tmp_path / "out" / "handle_points.py").read_text()
    about = json.loads((tmp_path / "out" / "policy.json").read_text())
    assert about["task"] == "door" and about["control_frequency_hz"] == TaskConfig().control_frequency


def test_a_policy_without_eyes_is_refused(tmp_path: Path) -> None:
    folder = trained(tmp_path / "policy", PolicyConfig(kwargs={"cloud": False}))
    with refused("E-POLICY-PORTABLE"):
        run(policy=folder, out=tmp_path / "out")


def test_a_policy_without_a_portable_form_is_refused(tmp_path: Path) -> None:
    folder = trained(tmp_path / "policy", PolicyConfig())
    config = json.loads((folder / "config.json").read_text())
    config["config"]["policy"] = "tests.toy_reach"
    (folder / "config.json").write_text(json.dumps(config))
    with refused("E-POLICY-PORTABLE"):
        run(policy=folder, out=tmp_path / "out")
