"""The diffusion policy: it learns, samples by its seed, goes through files, and is found by its name."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from roomkin.plugins.diffusion.policies.diffusion import Policy, signal_levels
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.plugins import find, qualify_module
from roomkin.stages.policies.base import ActionMode, TrainablePolicy, load_network
from roomkin.stages.training.augment import list_windows, make_batch
from roomkin.stages.training.dataset import read_demonstrations
from roomkin.stages.training.state import TrainingState
from roomkin.stages.training.train import run as train
from tests.refusals import refused
from tests.toy_reach import ToyReach, write_store

NAME = "roomkin.plugins.diffusion.policies.diffusion"
SMALL = {
    "policy": NAME,
    "points": 48,
    "kwargs": {"pointnet_width": 32, "width": 64, "layers": 2},
    "horizon": 6,
}


def trained(folder: Path, store: Path, **options: object) -> Path:
    """Folder of a policy that was trained on the toy."""
    train(episodes=(store,), per_store=8, options=json.dumps(SMALL | options), out=folder)
    return folder


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_store(tmp_path_factory.mktemp("toy") / "episodes.h5", 8)


def test_it_is_found_by_its_name_where_the_package_is_named() -> None:
    assert qualify_module("policies", find("policies", "diffusion", ["roomkin.plugins.diffusion"])) == NAME


def test_loss_and_error_of_the_sampled_actions_fall(tmp_path: Path, store: Path) -> None:
    folder = trained(tmp_path / "p", store, steps=60, warmup=0, batch_size=8, log_freq=15, translation=0.0)
    lines = [json.loads(line) for line in (folder / "metrics.jsonl").read_text().splitlines()]
    assert lines[-1]["loss"] < 0.5 * lines[0]["loss"]
    before, after = (error_of(policy, store) for policy in (policy_of(store), load_network(folder, "last")))
    assert after < 0.5 * before


def error_of(policy: TrainablePolicy, store: Path) -> float:
    """RMS error of the actions that a policy samples, on what it was trained on."""
    data = read_demonstrations((store,), 8)
    frames, real = list_windows(data, range(8), 6, 6)
    batch = make_batch(data, frames, real, 48, torch.Generator().manual_seed(0))
    with torch.no_grad():
        return float(policy.loss(batch.clouds, batch.proprio, batch.actions, batch.weights)[1])


def test_a_resumed_run_equals_a_whole_one(tmp_path: Path, store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options = {"steps": 4, "log_freq": 2}
    monkeypatch.setattr(TrainingState, "is_due", lambda state, every: True)
    whole, broken = trained(tmp_path / "whole", store, **options), tmp_path / "broken"
    save = TrainingState.save

    def power_cut(*args: Any) -> None:
        save(*args)
        raise KeyboardInterrupt

    monkeypatch.setattr(TrainingState, "save", power_cut)
    with pytest.raises(KeyboardInterrupt):
        trained(broken, store, **options)
    monkeypatch.setattr(TrainingState, "save", save)
    trained(broken, store, **options)
    one, two = (load_network(folder, "last") for folder in (whole, broken))
    assert int(one.get_buffer("updates")) == 4
    assert np.array_equal(actions(one, seed=3), actions(two, seed=3))


def actions(policy: TrainablePolicy, seed: int, steps: int = 6, mode: ActionMode = "sample") -> np.ndarray:
    """(steps, 7) actions in a toy episode."""
    acting, toy, done = policy.make_rollout_policy(2, mode), ToyReach(1), []
    acting.start_episode(1, seed)
    for _ in range(steps):
        cloud, proprio = toy.observe()
        done.append(acting.get_action([1], [cloud], [proprio])[0])
        toy.step(done[-1])
    return np.stack(done)


def policy_of(store: Path, **options: object) -> Policy:
    torch.manual_seed(0)
    policy = Policy(PolicyConfig.model_validate(SMALL | options))
    data = read_demonstrations((store,), 8)
    policy.fit(data.clouds, data.proprio, data.actions, torch.arange(len(data.clouds)))
    return policy.eval()


def test_sampling_goes_by_the_seed_alone(store: Path) -> None:
    policy = policy_of(store)
    assert np.array_equal(actions(policy, 5), actions(policy, 5))
    assert not np.allclose(actions(policy, 5), actions(policy, 6))
    assert np.abs(actions(policy, 5)).max() <= 1.0
    whole = policy_of(store, points=96)  # no point is left out by chance
    one, two = (actions(whole, seed, 1, "most_likely") for seed in (5, 6))
    assert np.array_equal(one, two)


def test_it_looks_again_when_its_plan_is_done(store: Path) -> None:
    policy = policy_of(store, kwargs={"n_action_steps": 2, "width": 64})
    looks: list[int] = []
    sample = policy.sample

    def noted(noise: torch.Tensor, seen: torch.Tensor) -> torch.Tensor:
        looks.append(len(noise))
        return sample(noise, seen)

    policy.sample = noted  # type: ignore[method-assign]
    actions(policy, 0, steps=5)
    assert looks == [1, 1, 1], "at steps 1, 3 and 5"


def test_noise_ends_as_the_actions_where_the_network_knows_them(store: Path) -> None:
    policy = policy_of(store)
    known = torch.rand(2, 6, 7) * 2 - 1
    policy.clean = lambda noisy, level, seen: known  # type: ignore[method-assign]
    assert torch.allclose(policy.sample(torch.randn(2, 6, 7), torch.zeros(2, policy.features)), known)
    signal = signal_levels(100)
    assert signal[0] == 1 and signal[-1] < 0.001 and (signal.diff() < 0).all()


def test_it_sees_marked_handles(store: Path) -> None:
    policy = policy_of(store, handle=True)
    cloud = torch.rand(3, 6, 48, 4)
    cloud[..., 3] = torch.arange(48) % 3 - 1  # handle, neither, finger
    loss, error = policy.loss(cloud, torch.rand(3, 6, 9), torch.rand(3, 6, 7), torch.ones(3, 6))
    loss.backward()
    assert error > 0 and policy.features == 32 + 9 + 4
    assert policy.pointnet.flag.weight.grad.abs().sum(1).min() > 0  # type: ignore[union-attr]


def test_what_it_does_not_know_is_refused() -> None:
    with refused("E-PLUGIN-OPTION", "did you mean 'num_inference_steps'?"):
        Policy(PolicyConfig(kwargs={"num_inference_stpes": 3}))
    with refused("E-PLUGIN-OPTION"):  # two steps at one level would divide by zero
        Policy(PolicyConfig(kwargs={"num_inference_steps": 10, "num_train_timesteps": 5}))
